"""The contract of an engine: something that runs a scenario and hands over one record per tick.

``inprocess`` runs all actors in this process; ``ros_engine`` runs them as ROS 2 nodes in child processes. Who consumes
the records (recorder, supervisor, progress line) cannot tell the difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from swarm_msgs_py.config import Config
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport
from swarm_msgs_py.messages.report import AgentReport, MissionReport
from swarm_msgs_py.step_io import AgentInputs, AgentOutputs, MissionInputs, MissionOutputs
from swarm_msgs_py.types import NodeId
from swarm_sim.simulation import Simulation, TickTruth


class AgentActor(Protocol):
    """One robot of the swarm."""

    def step(self, inputs: AgentInputs) -> AgentOutputs:
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
    def robots(self) -> tuple[NodeId, ...]:
        """All robots, ascending."""
        ...

    @property
    def period_s(self) -> float:
        """Control period [s]."""
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

    def simulation(self) -> Simulation:
        """Make the world at tick 0."""
        ...

    def mission(self) -> MissionActor:
        """Make the mission computer."""
        ...

    def agent(self, robot: NodeId) -> AgentActor:
        """Make one robot's agent."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TickRecord:
    """What happened in one tick, from observation to the end of motion.

    Attributes
    ----------
    tick : int
    truth : TickTruth
        True states at the start of the tick, and the sampled motion during it.
    reports : mapping of NodeId to AgentReport
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
    truth: TickTruth
    reports: Mapping[NodeId, AgentReport]
    mission: MissionReport | None
    plan: Plan | None
    alerts: tuple[str, ...] = ()
    lost: frozenset[NodeId] = field(default_factory=frozenset)

    @property
    def camera(self) -> CameraReport | None:
        """What the image of this tick told; None if there was none."""
        return None if self.mission is None else self.mission.camera


class Engine(Protocol):
    """Runs one scenario; use as a context manager, leave it to stop everything."""

    startup_s: float
    """Wall time from start to the first tick [s]."""

    def __enter__(self) -> Engine:
        """Start everything and return when the first tick can run."""
        ...

    def __exit__(self, *error: object) -> None:
        """Stop everything that was started; returns within 3 s, also after Ctrl-C."""
        ...

    def ticks(self) -> Iterator[TickRecord]:
        """Yield one record per tick, in order, without end (the consumer decides when to stop)."""
        ...
