"""What the engines ask of a world, whatever family of robots is in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.messages.camera import CameraInfo
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.radio.medium import RadioTraffic

InputsT = TypeVar("InputsT")


@dataclass(frozen=True, slots=True, eq=False)
class Observation(Generic[InputsT]):
    """What every actor learns at the start of a tick.

    Attributes
    ----------
    tick : int
    time : float
        Simulated time [s].
    agents : mapping of NodeId to the inputs of the family's agents
        Live robots, ascending.
    mission : MissionInputs
    """

    tick: int
    time: float
    agents: Mapping[NodeId, InputsT]
    mission: MissionInputs


class Truth(Protocol):
    """What is true of robots of any family in a tick; rows in the order of `TickedWorld.robots`."""

    @property
    def tick(self) -> int:
        """Number of the tick."""
        ...

    @property
    def time(self) -> float:
        """Simulated time at its start [s]."""
        ...

    @property
    def positions(self) -> FloatArray:
        """Where the robots are at its start, (n, 2) or (n, 3), world frame [m]."""
        ...

    @property
    def yaws(self) -> FloatArray:
        """Headings at its start, (n,) [rad]."""
        ...

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Whose electronics worked during the tick, (n,)."""
        ...

    @property
    def radio(self) -> RadioTraffic:
        """What was on the air."""
        ...


class TickedWorld(Protocol):
    """The world of one run. A tick is ``observe``, ``apply``, ``advance``."""

    @property
    def robots(self) -> tuple[NodeId, ...]:
        """All robots, ascending."""
        ...

    @property
    def tick(self) -> int:
        """Number of the current tick."""
        ...

    @property
    def camera_info(self) -> CameraInfo | None:
        """What the maker of the overhead camera says of it; None if there is none."""
        ...

    def observe(self) -> Observation[Any]:
        """Return what every actor learns in this tick; the same however often it is asked."""
        ...

    def apply(self, commands: Mapping[NodeId, Any], outboxes: Mapping[NodeId, tuple[bytes, ...]]) -> None:
        """Hand over what the actors answered in this tick; at most once per tick."""
        ...

    def advance(self) -> Truth:
        """Let the robots move, and begin the next tick."""
        ...

    def kill(self, node: NodeId) -> None:
        """End a node's electronics."""
        ...

    def revive(self, node: NodeId) -> None:
        """Switch a node's electronics on, where its body stands."""
        ...

    def is_on(self, node: NodeId) -> bool:
        """Return whether a node's electronics work."""
        ...

    @property
    def radii(self) -> FloatArray:
        """How large robots are drawn, in the order of `robots`, (n,) [m]."""
        ...

    @property
    def links(self) -> tuple[tuple[int, int], ...]:
        """Rows of robots that can hear each other now, each pair once."""
        ...

    def take_arrived(self) -> tuple[NodeId, ...]:
        """Return, once, the robots that were switched on because the scenario says so."""
        ...

    def take_died(self) -> tuple[NodeId, ...]:
        """Return, once, the nodes that died because the scenario says so."""
        ...

    def close(self) -> None:
        """Free what the world holds; may be called again."""
        ...
