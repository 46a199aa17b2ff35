"""What the actors of families share whose robots are all alike, and are watched by no camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from bringup.family import Family
from swarm_msgs_py.config import Config
from swarm_msgs_py.types import NodeId


class AlikeScenario(Protocol):
    """A scenario with one section of settings for all robots."""

    @property
    def family(self) -> Family:
        """Family of behavior."""
        ...

    @property
    def robot_count(self) -> int:
        """Number of robots."""
        ...

    @property
    def period_s(self) -> float:
        """Control period [s]."""
        ...

    @property
    def sim(self) -> Config:
        """Settings of the world."""
        ...

    @property
    def agent(self) -> Config:
        """Settings of every robot."""
        ...

    @property
    def mission(self) -> Config:
        """Settings of the mission computer."""
        ...


ScenarioT = TypeVar("ScenarioT", bound=AlikeScenario)


@dataclass(frozen=True, slots=True, eq=False)
class AlikeActors(Generic[ScenarioT]):
    """The part of `bringup.engine.Actors` that only reads the scenario.

    Attributes
    ----------
    scenario : AlikeScenario
        Resolved.
    """

    scenario: ScenarioT

    @property
    def family(self) -> str:
        """Name of the family of behavior."""
        return self.scenario.family.value

    @property
    def robots(self) -> tuple[NodeId, ...]:
        """All robots, ascending."""
        return tuple(NodeId(robot) for robot in range(self.scenario.robot_count))

    @property
    def period_s(self) -> float:
        """Control period [s]."""
        return self.scenario.period_s

    @property
    def image_hz(self) -> float | None:
        """How many images a second an overhead camera takes; None without one."""
        return None

    @property
    def world_config(self) -> Config:
        """Settings of the world."""
        return self.scenario.sim

    @property
    def mission_config(self) -> Config:
        """Settings of the mission computer."""
        return self.scenario.mission

    def agent_config(self, robot: NodeId) -> Config:  # noqa: ARG002 - all alike
        """Return the settings of one robot."""
        return self.scenario.agent
