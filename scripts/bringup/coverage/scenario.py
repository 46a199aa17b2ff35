"""What a coverage run is: solid, robots, events, settings and seed, as one strict configuration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bringup.family import Family
from bringup.scenario import Stoppable, check_name
from mission_computer.order_desk import OrderConfig
from swarm_agent.coverage.config import CoverageConfig, Expansion, Rule
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.points.config import PointSimConfig

METHODS: dict[str, tuple[Rule, Expansion]] = {
    "serial": (Rule.RANDOM, Expansion.SERIAL),
    "gain": (Rule.GAIN, Expansion.PARALLEL),
    "layout": (Rule.LAYOUT, Expansion.PREDICTED),
}
"""Rule and expansion by the name of the method; the first is the paper's."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SolidSpec(Config):
    """The shape to cover: a library solid, a file, or a description."""

    name: str | None = setting(None, "library solid; beside a file or description it is only what to call it")
    file: str | None = setting(None, "STL or OBJ mesh, or JSON description, relative to the scenario's own folder")
    solid: dict[str, Any] | None = setting(
        None, "description, e.g. {kind: ball, radius_m: 100.0}, or a union, intersection, difference of others"
    )
    scale: float = setting(1.0, "meters per unit of a mesh file", above=0.0)
    offset_m: tuple[float, float, float] = setting((0.0, 0.0, 0.0), "shift", unit="m")

    def __post_init__(self) -> None:
        """Check that there is exactly one source."""
        Config.__post_init__(self)
        if self.file is not None and self.solid is not None:
            raise ConfigError("file and solid are both given; remove one of them")
        if self.file is None and self.solid is None and self.name is None:
            raise ConfigError("no shape; give one of name, file or solid")


@dataclass(frozen=True, slots=True, kw_only=True)
class PointSwarmSpec(Config):
    """The swarm: one leader, robot 0, and followers (eq. (9))."""

    count: int = setting(100, "number of robots, the leader included", minimum=1, maximum=10_000)
    leader_m: tuple[float, float, float] = setting((0.0, 0.0, 0.0), "where the leader starts", unit="m")
    start_edge_m: float = setting(
        70.0, "followers start uniformly in a cube of this edge, whose lowest corner is the leader", unit="m", above=0.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageEventSpec(Config):
    """Something that befalls the swarm, or that the operator orders, during a run."""

    at_s: float = setting(help="when: from the first tick that begins then or later", unit="s", minimum=0.0)
    kill: tuple[int, ...] = setting((), "robots that vanish", minimum=0)
    join: tuple[int, ...] = setting((), "robots that were not there until now, and appear where they start", minimum=1)
    stop: Stoppable | None = setting(None, "mission_computer: its radio falls silent")
    shape: SolidSpec | None = setting(None, "another shape: the swarm gathers at the leader and covers it")
    velocity_mps: tuple[float, float, float] | None = setting(
        None, "the whole formation moves with this velocity from now on", unit="m/s"
    )

    def __post_init__(self) -> None:
        """Check that something happens, and no more than one order."""
        Config.__post_init__(self)
        if self.shape is not None and self.velocity_mps is not None:
            raise ConfigError("shape and velocity_mps are both given; make them two events")
        if not (self.kill or self.join or self.stop or self.shape) and self.velocity_mps is None:
            raise ConfigError(
                "an event without effect; give kill: [robots], join: [robots], stop: mission_computer, shape or "
                "velocity_mps"
            )

    @property
    def dead(self) -> tuple[NodeId, ...]:
        """Whose electronics it ends."""
        robots = tuple(map(NodeId, self.kill))
        return robots if self.stop is None else (*robots, MISSION)

    @property
    def is_order(self) -> bool:
        """Whether the operator says something."""
        return self.shape is not None or self.velocity_mps is not None


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageSuccessSpec(Config):
    """When the mission counts as achieved, on true states."""

    covered_fraction_min: float = setting(0.999, "share of the shape's volume", minimum=0.0, maximum=1.0)
    hold_s: float = setting(0.0, "how long the run goes on after the last event", unit="s", minimum=0.0)
    probes: int = setting(100_000, "random points by which the share is measured", minimum=1000, maximum=10_000_000)


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageScenario(Config):
    """One run, completely."""

    name: str = setting(help="name of the scenario; also part of the run folder's name")
    family: Family = setting(Family.COVERAGE, "family of behavior")
    description: str = setting("", "one line for people")
    seed: int = setting(1, "seed of everything that is drawn", minimum=0, maximum=2**32 - 1)
    duration_s: float = setting(1200.0, "simulated time after which the mission counts as failed", unit="s", above=0.0)
    shape: SolidSpec = setting(help="the solid to cover")
    obstacles: tuple[dict[str, Any], ...] = setting(
        (), "solids that block links, sight and motion, e.g. [{kind: box, center_m: [60, 0, 0], size_m: [5, 40, 40]}]"
    )
    robots: PointSwarmSpec = section(PointSwarmSpec, "the swarm")
    events: tuple[CoverageEventSpec, ...] = setting((), "what befalls the swarm, e.g. [{at_s: 200.0, kill: [95, 97]}]")
    success: CoverageSuccessSpec = section(CoverageSuccessSpec, "when the mission is achieved")
    sim: PointSimConfig = section(PointSimConfig, "the world")
    agent: CoverageConfig = section(CoverageConfig, "every robot's software; rule and expansion are the method")
    mission: OrderConfig = section(OrderConfig, "the mission computer")

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
        """Rule and expansion, as metrics and the command line name them."""
        chosen = self.agent.rule, self.agent.expansion
        named = [name for name, pair in METHODS.items() if pair == chosen]
        return named[0] if named else f"{self.agent.rule.value}-{self.agent.expansion.value}"
