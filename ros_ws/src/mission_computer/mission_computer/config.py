"""Settings of the mission computer."""

from __future__ import annotations

from dataclasses import dataclass

from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.partition.config import Method, PartitionConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionConfig(Config):
    """Everything that can be set about the mission computer."""

    position_m: tuple[float, float] = setting((0.0, 0.0), "where its antenna stands, world frame", unit="m")
    repeat_first_s: float = setting(
        5.0,
        "first pause before a plan is flooded again: robots that hear of a newer plan ask for it long before",
        unit="s",
        above=0.0,
    )
    repeat_growth: float = setting(1.5, "factor from one pause to the next", minimum=1.0, maximum=10.0)
    repeat_longest_s: float = setting(10.0, "longest pause between two floods", unit="s", above=0.0)
    lost_after_s: float = setting(
        20.0,
        "a robot that was heard once counts as lost after this long without a word from it or a route to it;"
        " driving robots lose touch for a few seconds",
        unit="s",
        above=0.0,
    )
    regroup_wait_s: float = setting(
        2.0, "wait this long after a loss or a return, so that several make one new plan", unit="s", minimum=0.0
    )
    regroup_pause_s: float = setting(10.0, "least time between two new plans for it", unit="s", minimum=0.0)
    body_drift_m: float = setting(
        1.0,
        "how far a lost robot may have driven on after its last report; about top speed times the report period",
        unit="m",
        minimum=0.0,
    )
    lead_s: float = setting(
        6.0,
        "a motion of the shape begins this long after it was ordered; so long a plan may need to get through the mesh",
        unit="s",
        minimum=0.0,
    )
    morph_s: float = setting(
        0.0,
        "how long the shape takes to turn into one that is ordered while the mission goes on; 0: it is a new shape"
        " to which robots drive by themselves",
        unit="s",
        minimum=0.0,
    )
    robot_speed_m_s: float | None = setting(
        None,
        "how fast robots drive, to warn of motions that are faster; in a scenario agent.control.speed_max_m_s if not"
        " set, for a mission computer alone no warning",
        unit="m/s",
        above=0.0,
    )
    nearest_types: bool = setting(
        False,
        "for task goals: whether the goals of each type are put where its robots are nearest, as far as these fit"
        " there; else the method alone decides (thesis)",
    )
    nearest_wait_s: float = setting(
        2.0, "longest that the first plan waits for that until all robots have said where they are", unit="s",
        minimum=0.0,
    )  # fmt: skip
    task: Task | None = setting(
        None,
        "what plans ask of the robots: goals, to share out goals that are computed here; partition, to find the goals"
        " from the shape, each robot by itself; forces or forces-literal, to let forces drive them, without goals;"
        " null: partition for the method voronoi, else goals",
    )
    vision: VisionConfig = section(VisionConfig, "how robots are found in the images of an overhead camera")
    partition: PartitionConfig = section(PartitionConfig, "how a shape becomes goals")

    @property
    def asked(self) -> Task:
        """What plans ask of the robots; by default what suits the method."""
        if self.task is not None:
            return self.task
        is_own = self.partition.method is Method.VORONOI and self.partition.extension is None
        return Task.PARTITION if is_own else Task.GOALS

    def __post_init__(self) -> None:
        """Check that the pauses are in order.

        Raises
        ------
        ConfigError
            If the longest pause is shorter than the first.
        """
        Config.__post_init__(self)
        if self.repeat_longest_s < self.repeat_first_s:
            raise ConfigError(
                f"repeat_longest_s must be >= repeat_first_s ({self.repeat_first_s:g} s), got {self.repeat_longest_s:g}"
            )
