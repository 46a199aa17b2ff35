"""What a run is: world, shape, robots, settings and seed, as one strict configuration that a YAML file holds."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, fields
from enum import Enum

from bringup.family import Family
from bringup.shape_specs import ShapeSpec, StageSpec
from mission_computer.config import MissionConfig
from mission_computer.shape.arena import Obstacle
from swarm_agent.config import AgentConfig
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.config import SimConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSpec(Config):
    """The arena: a named map, a map file, or bounds and obstacles written here."""

    name: str | None = setting(None, "map of the package; beside bounds_m it is only what to call them")
    file: str | None = setting(None, "JSON file, relative to the scenario's own folder")
    bounds_m: tuple[float, float, float, float] | None = setting(
        None, "least x, least y, greatest x, greatest y", unit="m"
    )
    obstacles: tuple[Obstacle, ...] = setting((), "walls, with bounds_m")

    def __post_init__(self) -> None:
        """Check that there is exactly one source, and that bounds enclose something."""
        Config.__post_init__(self)
        if self.file is not None and self.bounds_m is not None:
            raise ConfigError("file and bounds_m are both given; remove one of them")
        if self.bounds_m is None and self.obstacles:
            raise ConfigError("obstacles need bounds_m beside them; add bounds_m, or put the obstacles into the map")
        if self.bounds_m is None and self.file is None and self.name is None:
            raise ConfigError("no map; give one of name, file or bounds_m")
        if self.bounds_m is not None:
            x_min, y_min, x_max, y_max = self.bounds_m
            if x_min >= x_max or y_min >= y_max:
                raise ConfigError(f"bounds_m must be [x_min, y_min, x_max, y_max] in order, got {list(self.bounds_m)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotGroup(RobotType):
    """Robots of one type; types 1 to 3 may leave out what table 4.1 says of them."""

    count: int = setting(help="number of robots of this type", minimum=0, maximum=1000)
    colors: tuple[MarkerColor, ...] = setting(
        (), "color of the discs on the cover of each of them, by which an overhead camera knows it"
    )

    def __post_init__(self) -> None:
        """Check that every robot has its color, if any has.

        Raises
        ------
        ConfigError
            If there are more or fewer.
        """
        RobotType.__post_init__(self)
        if self.colors and len(self.colors) != self.count:
            raise ConfigError(
                f"colors names {len(self.colors)} for {self.count} robots; give one per robot, or remove it"
            )

    def robot_type(self) -> RobotType:
        """Return the type alone."""
        return RobotType(**{f.name: getattr(self, f.name) for f in fields(RobotType)})


@dataclass(frozen=True, slots=True, kw_only=True)
class StartSpec(Config):
    """Where robots stand at the start."""

    half_side_m: float = setting(45.0, "uniform in |x|, |y| <= this, drawn from the seed", unit="m", above=0.0)
    gap_m: float = setting(0.3, "least free gap to robots, obstacles and the arena's edge", unit="m", minimum=0.0)
    known_within_m: float | None = setting(
        2.0, "each robot is told its start point with this standard deviation per axis; null: it is told nothing",
        unit="m", above=0.0,
    )  # fmt: skip
    positions_m: tuple[tuple[float, float], ...] | None = setting(
        None, "instead: one [x, y] per robot, in the order of the types", unit="m"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotsSpec(Config):
    """The swarm."""

    types: tuple[RobotGroup, ...] = setting(help="one entry per robot type, with its count")
    start: StartSpec = section(StartSpec, "start points")
    position_sensor_share: float = setting(
        0.15, "share of the robots that carry a position sensor, spread over the types (thesis section 4.2)",
        minimum=0.0, maximum=1.0,
    )  # fmt: skip
    priorities: tuple[float, ...] | None = setting(
        None,
        "how much each robot's path counts, one number per robot in the order of the types; null: all the same"
        " (agent.decision.weight.priority)",
        minimum=0.01,
        maximum=100.0,
    )
    energies: tuple[float, ...] | None = setting(
        None,
        "energy of each robot at the start, one number per robot in the order of the types; null: all the same"
        " (agent.energy.initial)",
        unit="full stores",
        minimum=0.0,
        maximum=1.0,
    )

    def __post_init__(self) -> None:
        """Check that there are robots, that types are told once, and that lists fit the robots."""
        Config.__post_init__(self)
        for number, times in sorted(Counter(group.type for group in self.types).items()):
            if times > 1:
                raise ConfigError(f"types lists type {number} {times} times; merge them into one entry")
        if self.count == 0:
            raise ConfigError("types has no robots; set the count of at least one type to 1 or more")
        for color, times in Counter(color for group in self.types for color in group.colors).items():
            if times > 1:
                raise ConfigError(f"types gives {times} robots the color {color.value}; give each its own")
        points = self.start.positions_m
        if points is not None and len(points) != self.count:
            raise ConfigError(
                f"start.positions_m has {len(points)} points for {self.count} robots; give one per robot, or remove it"
            )
        for name, numbers in {"priorities": self.priorities, "energies": self.energies}.items():
            if numbers is not None and len(numbers) != self.count:
                raise ConfigError(
                    f"{name} has {len(numbers)} numbers for {self.count} robots; give one per robot, or remove it"
                )

    @property
    def count(self) -> int:
        """Number of robots."""
        return sum(group.count for group in self.types)


class Stoppable(Enum):
    """What a scenario can switch off besides robots."""

    MISSION_COMPUTER = "mission_computer"


@dataclass(frozen=True, slots=True, kw_only=True)
class EventSpec(Config):
    """Something that befalls the swarm during a run."""

    at_s: float = setting(help="when: from the first tick that begins then or later", unit="s", minimum=0.0)
    kill: tuple[int, ...] = setting((), "robots whose electronics die; their bodies stay where they are", minimum=0)
    add: tuple[int, ...] = setting(
        (), "robots that are switched on; those that were not killed before are off until then, as a reserve", minimum=0
    )
    stop: Stoppable | None = setting(
        None, "mission_computer: it is switched off, and its radio falls silent; the swarm goes on by itself"
    )

    def __post_init__(self) -> None:
        """Check that something happens.

        Raises
        ------
        ConfigError
            If nothing does.
        """
        Config.__post_init__(self)
        if not self.kill and not self.add and self.stop is None:
            raise ConfigError("an event without effect; give kill: [robots], add: [robots] or stop: mission_computer")

    @property
    def nodes(self) -> tuple[NodeId, ...]:
        """Whose electronics it ends."""
        robots = tuple(map(NodeId, self.kill))
        return robots if self.stop is None else (*robots, MISSION)


@dataclass(frozen=True, slots=True, kw_only=True)
class SuccessSpec(Config):
    """When the mission counts as achieved, on true states (spec 14.4)."""

    speed_max_m_s: float = setting(
        0.01, "robots below this speed are at rest (thesis eq. (4.1))", unit="m/s", above=0.0
    )
    hold_s: float = setting(3.0, "how long all must be at rest inside the shape", unit="s", minimum=0.0)
    goal_tolerance_m: float = setting(
        1.0, "largest distance of a robot from its goal: three standard deviations of a position from ranges",
        unit="m", above=0.0,
    )  # fmt: skip
    live_share_min: float = setting(
        0.75, "share of the robots that must live; a shape with fewer is not the shape", minimum=0.0, maximum=1.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario(Config):
    """One run, completely."""

    name: str = setting(help="name of the scenario; also part of the run folder's name")
    family: Family = setting(Family.FORMATION, "family of behavior")
    description: str = setting("", "one line for people")
    seed: int = setting(1, "seed of everything that is drawn", minimum=0, maximum=2**32 - 1)
    duration_s: float = setting(300.0, "simulated time after which the mission counts as failed", unit="s", above=0.0)
    shape: ShapeSpec = setting(help="the contour to form")
    stages: tuple[StageSpec, ...] = setting(
        (),
        "shapes after the first, in their order, e.g. [{shape: {name: iso_2_rect}, over_s: 60.0, at_s: 150.0},"
        " {split: {gap_m: 4.0}, over_s: 40.0}, {join: true, over_s: 40.0}]",
    )
    map: MapSpec = setting(help="the arena")
    robots: RobotsSpec = setting(help="the swarm")
    events: tuple[EventSpec, ...] = setting(
        (), "what befalls the swarm, e.g. [{at_s: 30.0, kill: [3, 7]}, {at_s: 40.0, stop: mission_computer}]"
    )
    success: SuccessSpec = section(SuccessSpec, "when the mission is achieved")
    sim: SimConfig = section(SimConfig, "the world")
    agent: AgentConfig = section(AgentConfig, "every robot's software")
    mission: MissionConfig = section(
        MissionConfig,
        "the mission computer; mission.partition.method, or mission.task if it is of forces, is the method",
    )

    def __post_init__(self) -> None:
        """Check that the name can be a part of a folder's name."""
        Config.__post_init__(self)
        check_name(self.name)

    @property
    def robot_count(self) -> int:
        """Number of robots."""
        return self.robots.count

    @property
    def period_s(self) -> float:
        """Duration of a tick [s]."""
        return self.sim.period_s

    @property
    def method(self) -> str:
        """Method by which the family does its work, as metrics and the command line name it."""
        task = self.mission.asked
        return self.mission.partition.name if task.has_goals else task.value

    @property
    def deaths(self) -> dict[NodeId, int]:
        """The tick from which on a node is dead, for the robots (and `MISSION`) that the events end."""
        return {node: tick_from(event.at_s, self.sim.period_s) for event in self.events for node in event.nodes}

    @property
    def arrivals(self) -> dict[NodeId, int]:
        """The tick from which on a robot is on that an event adds."""
        return {NodeId(robot): tick_from(event.at_s, self.sim.period_s) for event in self.events for robot in event.add}


def check_name(name: str) -> None:
    """Refuse the name of a scenario that cannot be a part of a folder's name.

    Raises
    ------
    ConfigError
    """
    if not name or not all(letter.isalnum() or letter in "-_." for letter in name):
        raise ConfigError(f"name must be letters, digits, '-', '_' and '.', got '{name}'")


def tick_from(time_s: float, period_s: float) -> int:
    """Return the first tick that begins at a time [s] or later."""
    return math.ceil(time_s / period_s - 1e-9)


def rescaled_counts(counts: tuple[int, ...], total: int) -> tuple[int, ...]:
    """Return counts that sum to `total` in the proportions of `counts` (largest remainder, first come first).

    Parameters
    ----------
    counts : tuple of int
        At least one is positive.
    total : int
    """
    shares = [total * count / sum(counts) for count in counts]
    whole = [math.floor(share) for share in shares]
    by_remainder = sorted(range(len(counts)), key=lambda index: (whole[index] - shares[index], index))
    for index in by_remainder[: total - sum(whole)]:
        whole[index] += 1
    return tuple(whole)
