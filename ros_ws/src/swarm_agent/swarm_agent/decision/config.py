"""Settings of the goal decision."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.messages.bodies import Objective


@dataclass(frozen=True, slots=True, kw_only=True)
class WeightConfig(Config):
    """How much a meter of this robot's path counts: ``priority * (1 + energy_gain * (1 - energy))``, from 1/256 to 256.

    The swarm minimizes weighted paths, so a robot of twice the weight goes half as far out of its way for others.
    """

    priority: float = setting(
        1.0, "weight of the robot at full charge; in a scenario robots.priorities", minimum=0.01, maximum=100.0
    )
    energy_gain: float = setting(
        1.0, "by which share more a robot counts that has no energy left: who is low on energy shall drive less",
        minimum=0.0, maximum=100.0,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SwapConfig(Config):
    """Exchange of goals between two robots of one type of which the one stands in the other's way."""

    after_s: float | None = setting(
        4.0,
        "a robot that has called itself blocked for this long offers an exchange; after each attempt within a plan it"
        " waits twice as long; null: never",
        unit="s",
        above=0.0,
    )
    distance_m: float = setting(1.6, "farthest that the robot in the way is", unit="m", above=0.0)
    detour_max_m: float = setting(
        0.5, "a robot is in the way to where a path through its place is longer by no more than this", unit="m",
        minimum=0.0,
    )  # fmt: skip
    worth_m: float = setting(
        2.0, "by how much both paths together may become longer; twice as much in each further attempt",
        unit="m", above=0.0,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class DecisionConfig(Config):
    """The decentralized decision: what it is for, and its timing."""

    objective: Objective = setting(
        Objective.TOTAL,
        "what the assignment of goals minimizes: total, the sum of all paths (thesis); or bottleneck, the longest path"
        " of any robot and with that the sum; where robots differ, the majority decides",
    )
    weight: WeightConfig = section(WeightConfig, "how much this robot's path counts")
    swap: SwapConfig = section(SwapConfig, "exchange of goals with a robot that stands in the way")

    strategy: str | None = setting(
        None,
        "instead of what suits the plan's method: a decision method that an installed package adds, by its name"
        " (docs/extending.md)",
    )
    cost_step_m: float = setting(
        0.01,
        "robots tell each other path lengths in whole steps of this, up to 65,534; the same for the whole swarm",
        unit="m",
        minimum=1e-4,
        maximum=1.0,
    )
    patience_s: float = setting(
        8.0, "how long a robot stands still for the cost rows of its type to be complete", unit="s", minimum=0.0
    )
    rally_after_s: float = setting(
        6.0,
        "without a plan for this long, or without a goal and a route to the mission computer, drive to the rally point"
        " to hear a plan",
        unit="s",
        minimum=0.0,
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
    refresh_pause_s: float = setting(
        5.0, "least time between two cost rows of a robot within a plan, so that several newcomers cost one", unit="s",
        minimum=0.0,
    )  # fmt: skip
    refresh_spread_s: float = setting(
        2.0, "robots take turns within this time to send such rows, to spare the radio", unit="s", minimum=0.0
    )
    keep_goal_m: float = setting(
        0.5,
        "in a fresh cost row the goal that the robot has costs this much less, so that only a gain of that much moves"
        " robots to other goals (spec 11.5)",
        unit="m",
        minimum=0.0,
    )
    settle_s: float = setting(
        1.5,
        "a robot changes to another goal of the same plan only if the rows say so for this long; rows come in bursts",
        unit="s",
        minimum=0.0,
    )
    repair_after_s: float = setting(
        1.5,
        "a neighbor's rows differ from an own set that is unchanged for this long: ask for what is missing",
        unit="s",
        above=0.0,
    )
    plan_wait_s: float = setting(
        2.0,
        "a neighbor has had a newer plan for this long: ask it for the plan, whose flood must have been lost; where two"
        " parts of a network meet, the mission computer's plan for both should come first",
        unit="s",
        minimum=0.0,
    )
    repair_period_s: float = setting(1.0, "least time between two such requests", unit="s", above=0.0)
    report_period_s: float = setting(2.0, "between two reports to the mission computer", unit="s", above=0.0)
