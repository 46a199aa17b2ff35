"""How scenarios of the coverage family are written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bringup.coverage.scenario import METHODS, CoverageScenario
from bringup.coverage.solids import SOLIDS
from bringup.family import Family
from bringup.formation_kind import named_or_file
from bringup.origin import Override
from swarm_msgs_py.config import Config
from swarm_msgs_py.errors import ConfigError


class CoverageKind:
    """Implements `bringup.family.Kind`."""

    family = Family.COVERAGE
    scenario: type[Config] = CoverageScenario
    methods = tuple(METHODS)

    def completed(self, data: dict[str, Any]) -> dict[str, Any]:
        """Return the data: nothing may be left out that has no default."""
        return data

    def located(self, data: dict[str, Any], folder: str) -> None:
        """Make the files of shapes relative to the present folder."""
        events = data.get("events")
        holders = [data, *(events if isinstance(events, list) else [])]
        for holder in holders:
            shape = holder.get("shape") if isinstance(holder, dict) else None
            if isinstance(shape, dict) and isinstance(shape.get("file"), str):
                shape["file"] = str(Path(folder) / shape["file"])

    def with_count(self, data: dict[str, Any], count: int) -> None:
        """Set the number of robots."""
        data.setdefault("robots", {})["count"] = count

    def shape_override(self, source: str) -> Override:
        """Return the override of ``--shape``: a library solid or a file; it replaces the shape with its placement."""
        return Override(f"--shape {source}", "shape", named_or_file(source, tuple(SOLIDS)))

    def map_override(self, source: str) -> Override:
        """Refuse ``--map``.

        Raises
        ------
        ConfigError
        """
        raise ConfigError(f"--map {source}: coverage has no maps; write obstacles into the scenario")

    def method_overrides(self, name: str) -> tuple[Override, ...]:
        """Return the overrides of ``--method``: rule and expansion."""
        rule, expansion = METHODS[name]
        flag = f"--method {name}"
        return Override(flag, "agent.rule", rule.value), Override(flag, "agent.expansion", expansion.value)

    def physics_override(self, backend: str) -> Override:
        """Refuse ``--physics``.

        Raises
        ------
        ConfigError
        """
        raise ConfigError(f"--physics {backend}: coverage has point robots and no physics back end; leave it out")
