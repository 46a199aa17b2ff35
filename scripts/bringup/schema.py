"""JSON schema of scenario files, made from the configuration classes: ``python -m bringup.schema`` rewrites it."""

from __future__ import annotations

import dataclasses
import json
import types
import typing
from enum import Enum
from pathlib import Path
from typing import Any

from bringup.assembly.scenario import AssemblyScenario
from bringup.coverage.scenario import CoverageScenario
from bringup.scenario import RobotGroup, Scenario
from bringup.scenario_file import SCENARIOS
from swarm_msgs_py.config import Config, Setting, settings_of

SCHEMA_FILE: Path = SCENARIOS / "scenario.schema.json"
COVERAGE_SCHEMA_FILE: Path = SCENARIOS / "coverage" / "coverage.schema.json"
ASSEMBLY_SCHEMA_FILE: Path = SCENARIOS / "assembly" / "assembly.schema.json"
SCALARS: dict[type, str] = {bool: "boolean", int: "integer", float: "number", str: "string"}
REQUIRED_OF_A_GROUP = ["type", "count"]  # types 1 to 3 take the rest from table 4.1


def scenario_schema(cls: type[Config] = Scenario) -> str:
    """Return the text of the schema file of a family's scenarios."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": cls.__name__, **_object(cls)}
    return json.dumps(schema, indent=1) + "\n"


def _object(cls: type[Config]) -> dict[str, Any]:
    hints, settings = typing.get_type_hints(cls), settings_of(cls)
    declared = dataclasses.fields(cls)
    required = [
        f.name for f in declared if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
    ]
    properties = {}
    for f in declared:
        about = settings.get(f.name, Setting(""))
        unit = f" [{about.unit}]" if about.unit else ""
        properties[f.name] = {"description": about.help + unit, **_value(hints[f.name], about)}
        if f.default is not dataclasses.MISSING and not isinstance(f.default, Config):
            properties[f.name]["default"] = f.default.value if isinstance(f.default, Enum) else f.default
    return {
        "type": "object",
        "properties": properties,
        "required": REQUIRED_OF_A_GROUP if cls is RobotGroup else required,
        "additionalProperties": False,
    }


def _value(hint: Any, about: Setting) -> dict[str, Any]:  # noqa: PLR0911 - a case each
    """Return the schema of one type hint; the limits of a setting hold for every number in it."""
    origin = typing.get_origin(hint)
    if origin in (types.UnionType, typing.Union):
        (inner,) = [arg for arg in typing.get_args(hint) if arg is not type(None)]
        return {"anyOf": [_value(inner, about), {"type": "null"}]}
    if origin is dict:
        return {"type": "object", "properties": {}, "required": [], "additionalProperties": True}
    if origin is tuple:
        first, *others = typing.get_args(hint)
        if others == [Ellipsis]:
            return {"type": "array", "items": _value(first, about)}
        count = 1 + len(others)
        return {"type": "array", "items": _value(first, about), "minItems": count, "maxItems": count}
    if issubclass(hint, Config):
        return _object(hint)
    if issubclass(hint, Enum):
        return {"enum": [member.value for member in hint]}
    limits = {"minimum": about.minimum, "maximum": about.maximum, "exclusiveMinimum": about.above}
    is_number = hint in (int, float)
    return {"type": SCALARS[hint], **{name: limit for name, limit in limits.items() if is_number and limit is not None}}


if __name__ == "__main__":
    SCHEMA_FILE.write_text(scenario_schema(), encoding="utf-8")
    COVERAGE_SCHEMA_FILE.write_text(scenario_schema(CoverageScenario), encoding="utf-8")
    ASSEMBLY_SCHEMA_FILE.write_text(scenario_schema(AssemblyScenario), encoding="utf-8")
