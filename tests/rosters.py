"""Swarms for which the packaged maps and shapes are made."""

from __future__ import annotations

from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster, TypeGroup

FIELD = Roster.of(kind for kind, count in zip(THESIS_TYPES, (17, 17, 16), strict=True) for _ in range(count))
"""The fifty robots of the 100 m field, ``arena_main``."""

TABLE = Roster(
    groups=tuple(
        TypeGroup(type=number, count=count, coverage_radius_m=radius)
        for number, count, radius in ((1, 1, 0.16), (2, 2, 0.11), (3, 2, 0.08))
    )
)
"""The five robots of the 2 m table, ``arena_table``."""
