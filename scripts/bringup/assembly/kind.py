"""How scenarios of the assembly family are written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bringup.assembly.scenario import AssemblyScenario, Navigation
from bringup.family import Family
from bringup.formation_kind import named_or_file
from bringup.origin import Override
from mission_computer.assembly.map_library import map_names
from swarm_msgs_py.config import Config
from swarm_msgs_py.errors import ConfigError
from swarm_sim.boats.pool import BodyKind


class AssemblyKind:
    """Implements `bringup.family.Kind`."""

    family = Family.ASSEMBLY
    scenario: type[Config] = AssemblyScenario
    methods = tuple(navigation.value for navigation in Navigation)

    def completed(self, data: dict[str, Any]) -> dict[str, Any]:
        """Return the data: nothing may be left out that has no default."""
        return data

    def located(self, data: dict[str, Any], folder: str) -> None:
        """Make the file of the map relative to the present folder."""
        spec = data.get("map")
        if isinstance(spec, dict) and isinstance(spec.get("file"), str):
            spec["file"] = str(Path(folder) / spec["file"])

    def with_count(self, data: dict[str, Any], count: int) -> None:  # noqa: ARG002 - a map has its boats
        """Refuse ``--agents``.

        Raises
        ------
        ConfigError
        """
        raise ConfigError(f"--agents {count}: the map says how many boats there are; choose another map")

    def shape_override(self, source: str) -> Override:
        """Refuse ``--shape``.

        Raises
        ------
        ConfigError
        """
        raise ConfigError(f"--shape {source}: what boats build is a map; use --map NAME or FILE")

    def map_override(self, source: str) -> Override:
        """Return the override of ``--map``: a map of the library or a file; it replaces the map and its docks."""
        return Override(f"--map {source}", "map", named_or_file(source, map_names()))

    def method_overrides(self, name: str) -> tuple[Override, ...]:
        """Return the overrides of ``--method``: who finds the ways."""
        return (Override(f"--method {name}", "navigation", name),)

    def physics_override(self, backend: str) -> Override:
        """Return the override of ``--physics``: bullet, or massdamper for the planar bodies without contacts."""
        kind = BodyKind.BULLET if backend == BodyKind.BULLET.value else BodyKind.PLANAR
        return Override(f"--physics {backend}", "sim.bodies", kind.value)
