"""Settings of the path planner."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningConfig(Config):
    """How obstacles are grown before paths are sought."""

    clearance_margin_m: float = setting(
        0.1, "gap that paths keep between a robot's coverage circle and obstacles", unit="m", minimum=0.0, maximum=10.0
    )
    polygon_sides: int = setting(
        16, "sides of the regular polygon that stands for the coverage circle; more sides, shorter paths, more nodes",
        minimum=4, maximum=256,
    )  # fmt: skip
