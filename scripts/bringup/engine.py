"""The contract of an engine: something that runs a scenario and hands over one record per tick.

``inprocess`` runs all actors in this process; ``ros_engine`` runs them as ROS 2 nodes in child processes. Who consumes
the records (recorder, supervisor, progress line) cannot tell the difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

from swarm_msgs_py.config import Config
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport
from swarm_msgs_py.messages.report import AgentReport, MissionReport
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs
from swarm_msgs_py.types import NodeId
from swarm_sim.simulation import TickTruth
from swarm_sim.ticked_world import TickedWorld, Truth

TruthT = TypeVar("TruthT", bound=Truth)
ReportT = TypeVar("ReportT")


class AgentAnswer(Protocol):
    """All that one robot of any family does in one tick."""

    @property
    def tick(self) -> int:
        """Number of the tick."""
        ...

    @property
    def command(self) -> Any:
        """What it asks of its body."""
        ...

    @property
    def outbox(self) -> tuple[bytes, ...]:
        """Frames to transmit."""
        ...

    @property
    def report(self) -> Any:
        """What it says of itself, for people and metrics."""
        ...


class AgentActor(Protocol):
    """One robot of the swarm; what it senses and what it answers is up to its family."""

    def step(self, inputs: Any) -> AgentAnswer:
        """Advance by one tick."""
        ...


class MissionActor(Protocol):
    """The mission computer."""

    @property
    def has_camera(self) -> bool:
        """Whether it looks at the robots from above."""
        ...

    def step(self, inputs: MissionInputs) -> MissionOutputs:
        """Advance by one tick."""
        ...

    def picture(self) -> ImageArray | None:
        """Return the last image with what was read out of it; None if there was none."""
        ...


class Actors(Protocol):
    """Makes the actors of one scenario. Picklable; equal scenarios make equal actors, in whatever process."""

    @property
    def family(self) -> str:
        """Name of the family of behavior: decides how its steps travel over ROS."""
        ...

    @property
    def robots(self) -> tuple[NodeId, ...]:
        """All robots, ascending."""
        ...

    @property
    def period_s(self) -> float:
        """Control period [s]."""
        ...

    @property
    def image_hz(self) -> float | None:
        """How many images a second an overhead camera takes; None without one."""
        ...

    @property
    def world_config(self) -> Config:
        """Settings of the world, as its node declares them."""
        ...

    @property
    def mission_config(self) -> Config:
        """Settings of the mission computer, as its node declares them."""
        ...

    def agent_config(self, robot: NodeId) -> Config:
        """Return the settings of one robot, as its node declares them."""
        ...

    def simulation(self) -> TickedWorld:
        """Make the world at tick 0."""
        ...

    def mission(self) -> MissionActor:
        """Make the mission computer."""
        ...

    def agent(self, robot: NodeId) -> AgentActor:
        """Make one robot's agent."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TickRecord(Generic[TruthT, ReportT]):
    """What happened in one tick, from observation to the end of motion.

    Attributes
    ----------
    tick : int
    truth : TickTruth, or that of another family
        True states at the start of the tick, and the motion during it.
    reports : mapping of NodeId to AgentReport, or that of another family
        Of every agent that answered in time.
    mission : MissionReport or None
        None when the mission computer did not answer.
    plan : Plan or None
        The plan, in the tick in which it changed.
    alerts : tuple of str
        One line each: a node died, an agent fell silent, a shape was refused.
    lost : frozenset of NodeId
        Robots (and `MISSION`) that are dead since some tick up to this one.
    """

    tick: int
    truth: TruthT
    reports: Mapping[NodeId, ReportT]
    mission: MissionReport | None
    plan: Plan | None
    alerts: tuple[str, ...] = ()
    lost: frozenset[NodeId] = field(default_factory=frozenset)

    @property
    def camera(self) -> CameraReport | None:
        """What the image of this tick told; None if there was none."""
        return None if self.mission is None else self.mission.camera


FormationRecord = TickRecord[TickTruth, AgentReport]
"""One tick of the formation family."""


class Engine(Protocol):
    """Runs one scenario; use as a context manager, leave it to stop everything."""

    startup_s: float
    """Wall time from start to the first tick [s]."""

    notes: tuple[str, ...]
    """What the operator should read after the run, a line each; complete once the engine has stopped."""

    def __enter__(self) -> Engine:
        """Start everything and return when the first tick can run."""
        ...

    def __exit__(self, *error: object) -> None:
        """Stop everything that was started; returns within 3 s, also after Ctrl-C, or once a recording is finished."""
        ...

    def ticks(self) -> Iterator[TickRecord[Any, Any]]:
        """Yield one record per tick, in order, without end (the consumer decides when to stop)."""
        ...
