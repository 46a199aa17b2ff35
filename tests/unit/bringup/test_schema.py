from __future__ import annotations

import json
from typing import Any

import pytest
import yaml

from bringup.assembly.scenario import AssemblyScenario
from bringup.coverage.scenario import CoverageScenario
from bringup.family import Family
from bringup.scenario_file import SCENARIOS, load_any, scenario_names
from bringup.schema import ASSEMBLY_SCHEMA_FILE, COVERAGE_SCHEMA_FILE, SCHEMA_FILE, scenario_schema
from swarm_msgs_py.config import dump_config

SCHEMA = json.loads(scenario_schema())
KINDS = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}


def complaints(value: Any, schema: dict[str, Any], place: str = "") -> list[str]:  # noqa: PLR0911 - a case each
    """Check the part of JSON schema that ours uses."""
    if "anyOf" in schema:
        found = [complaints(value, option, place) for option in schema["anyOf"]]
        return min(found, key=len)
    if "enum" in schema:
        return [] if value in schema["enum"] else [f"{place}: {value} is none of {schema['enum']}"]
    if schema["type"] == "null":
        return [] if value is None else [f"{place}: not null"]
    if not isinstance(value, KINDS[schema["type"]]):
        return [f"{place}: {value!r} is no {schema['type']}"]
    if isinstance(value, dict):
        unknown = [
            f"{place}.{key}: unknown"
            for key in value
            if key not in schema["properties"] and not schema["additionalProperties"]
        ]
        missing = [f"{place}.{key}: missing" for key in schema["required"] if key not in value]
        known = ((key, item) for key, item in value.items() if key in schema["properties"])
        return unknown + missing + [c for k, v in known for c in complaints(v, schema["properties"][k], f"{place}.{k}")]
    if isinstance(value, list):
        return [c for index, item in enumerate(value) for c in complaints(item, schema["items"], f"{place}[{index}]")]
    if isinstance(value, str | bool):
        return []
    low, above, high = (schema.get(name) for name in ("minimum", "exclusiveMinimum", "maximum"))
    fits = (low is None or value >= low) and (above is None or value > above) and (high is None or value <= high)
    return [] if fits else [f"{place}: {value} is out of range"]


def test_the_published_schema_is_the_one_of_the_code() -> None:
    assert SCHEMA_FILE.read_text() == scenario_schema(), "run `python -m bringup.schema` in scripts/"
    assert COVERAGE_SCHEMA_FILE.read_text() == scenario_schema(CoverageScenario), "the same"
    assert ASSEMBLY_SCHEMA_FILE.read_text() == scenario_schema(AssemblyScenario), "the same"


SCHEMAS = {
    Family.FORMATION: (SCENARIOS, SCHEMA),
    Family.COVERAGE: (SCENARIOS / "coverage", json.loads(scenario_schema(CoverageScenario))),
    Family.ASSEMBLY: (SCENARIOS / "assembly", json.loads(scenario_schema(AssemblyScenario))),
}


@pytest.mark.parametrize("name", scenario_names())
def test_ready_made_scenarios_follow_the_schema_as_written_and_as_dumped(name: str) -> None:
    scenario = load_any(name)[0]
    folder, schema = SCHEMAS[scenario.family]
    written = yaml.safe_load((folder / f"{name}.yaml").read_text())

    assert complaints(written, schema) == []
    assert complaints(dump_config(scenario), schema) == []


def test_the_schema_refuses_what_the_loader_refuses() -> None:
    written = yaml.safe_load((SCENARIOS / "smoke-4.yaml").read_text())
    bad = {**written, "speed": 1, "seed": "one", "duration_s": 0}
    del bad["shape"]

    assert complaints(bad, SCHEMA) == [
        ".speed: unknown",
        ".shape: missing",
        ".duration_s: 0 is out of range",
        ".seed: 'one' is no integer",
    ]


def test_limits_and_units_are_told() -> None:
    loss = SCHEMA["properties"]["sim"]["properties"]["radio"]["properties"]["loss"]

    assert (loss["minimum"], loss["maximum"], loss["default"]) == (0.0, 1.0, 0.0)
    assert SCHEMA["properties"]["duration_s"]["description"].endswith("[s]")
    assert SCHEMA["properties"]["duration_s"]["exclusiveMinimum"] == 0.0
