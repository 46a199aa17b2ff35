"""Settings of the goal decision."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class DecisionConfig(Config):
    """Timing of the decentralized decision."""

    patience_s: float = setting(
        8.0, "how long a robot stands still for the cost rows of its type to be complete", unit="s", minimum=0.0
    )
    rally_after_s: float = setting(
        6.0, "without a plan for this long, drive to the rally point to hear one", unit="s", minimum=0.0
    )
    rally_point_m: tuple[float, float] | None = setting(
        None,
        "where to hear a plan; in a scenario mission.position_m if not set, on a robot alone the origin",
        unit="m",
    )
    refresh_distance_m: float = setting(
        2.0,
        "a robot that has moved this far since its last cost row sends a new one when membership changes",
        unit="m",
        above=0.0,
    )
    repair_after_s: float = setting(
        1.5,
        "a neighbor's rows differ from an own set that is unchanged for this long: ask for what is missing",
        unit="s",
        above=0.0,
    )
    repair_period_s: float = setting(1.0, "least time between two such requests", unit="s", above=0.0)
    report_period_s: float = setting(2.0, "between two reports to the mission computer", unit="s", above=0.0)
