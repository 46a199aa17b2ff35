"""How scenarios of the formation family are written: table 4.1 behind the types, library shapes, maps, methods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from bringup.family import Family
from bringup.origin import Override
from bringup.scenario import Scenario, rescaled_counts
from mission_computer.shape import TEXT_PREFIX, library_names
from swarm_msgs_py.config import Config
from swarm_msgs_py.extensions import PARTITION_METHODS, extension_names
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.partition import Method
from swarm_msgs_py.robots import THESIS_TYPES

FORCE_TASKS = tuple(task.value for task in Task if not task.has_goals)
"""Methods that are no partition of the shape."""

OWN_METHODS = tuple(method.value for method in Method)
"""Partition methods of this project."""

METHODS = (*OWN_METHODS, *FORCE_TASKS, *extension_names(PARTITION_METHODS))
"""Methods as the command line names them: partitions, forces, and what installed packages add."""

FONT_FILES = (".ttf", ".otf", ".ttc")
"""Endings by which a font is a file."""


class FormationKind:
    """Implements `bringup.family.Kind`."""

    family = Family.FORMATION
    scenario: type[Config] = Scenario
    methods = METHODS

    def completed(self, data: dict[str, Any]) -> dict[str, Any]:
        """Fill in what table 4.1 says of the robot types."""
        robots = data.get("robots")
        if not isinstance(robots, Mapping) or not isinstance(robots.get("types"), list):
            return data
        known = {kind.type: {f.name: getattr(kind, f.name) for f in fields(kind)} for kind in THESIS_TYPES}
        full = [
            {**known[group["type"]], **group}
            if isinstance(group, Mapping) and isinstance(group.get("type"), int) and group["type"] in known
            else group
            for group in robots["types"]
        ]
        return {**data, "robots": {**robots, "types": full}}

    def located(self, data: dict[str, Any], folder: str) -> None:
        """Make the files of shapes and map relative to the present folder."""
        stages = data.get("stages")
        parts = [data.get("shape"), data.get("map")]
        parts += [stage.get("shape") for stage in stages if isinstance(stage, dict)] if isinstance(stages, list) else []
        for part in parts:
            if isinstance(part, dict) and isinstance(part.get("file"), str):
                part["file"] = str(Path(folder) / part["file"])
            if isinstance(part, dict) and str(part.get("font", "")).lower().endswith(FONT_FILES):
                part["font"] = str(Path(folder) / part["font"])

    def with_count(self, data: dict[str, Any], count: int) -> None:
        """Rescale the mix of types."""
        groups = data["robots"]["types"]
        for group, share in zip(groups, rescaled_counts(tuple(g["count"] for g in groups), count), strict=True):
            group["count"] = share

    def shape_override(self, source: str) -> Override:
        """Return the override of ``--shape``: a library name, a file or ``text:`` with a text.

        It replaces the scenario's shape together with its placement.
        """
        if source.startswith(TEXT_PREFIX):
            return Override(f"--shape {source}", "shape", {"text": source.removeprefix(TEXT_PREFIX)})
        return Override(f"--shape {source}", "shape", named_or_file(source, library_names()))

    def map_override(self, source: str) -> Override:
        """Return the override of ``--map``: a map of the package or a file."""
        is_file = bool(Path(source).suffix) or "/" in source
        value = {"file": str(Path(source).absolute())} if is_file else {"name": source}
        return Override(f"--map {source}", "map", value)

    def method_overrides(self, name: str) -> tuple[Override, ...]:
        """Return the overrides of ``--method``: how shapes are partitioned, or that forces do it.

        With a partition method, who computes the goals is what suits it, unless a later override says otherwise.
        """
        flag = f"--method {name}"
        if name in FORCE_TASKS:
            return (Override(flag, "mission.task", name),)
        is_own = name in OWN_METHODS
        chosen = Override(flag, "mission.partition.method", name) if is_own else None
        added = Override(flag, "mission.partition.extension", None if is_own else name)
        return (*([chosen] if chosen else []), added, Override(flag, "mission.task", None))

    def physics_override(self, backend: str) -> Override:
        """Return the override of ``--physics``."""
        return Override(f"--physics {backend}", "sim.physics.backend", backend)


def named_or_file(source: str, names: tuple[str, ...]) -> dict[str, str]:
    """Return what a shape section says of a word that is one of `names`, or a file."""
    is_file = source not in names and (bool(Path(source).suffix) or "/" in source or Path(source).is_file())
    return {"file": str(Path(source).absolute())} if is_file else {"name": source}


FORMATION = FormationKind()
shape_override, method_overrides, map_override = (
    FORMATION.shape_override, FORMATION.method_overrides, FORMATION.map_override
)  # fmt: skip
