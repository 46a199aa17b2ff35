"""What worlds of robots that obey velocities have in common: ticks, answers, radios, deaths and arrivals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Generic, TypeVar

import numpy as np

from swarm_msgs_py.messages.camera import CameraInfo
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId
from swarm_sim.electronics import Electronics
from swarm_sim.ticked_world import Observation

InputsT = TypeVar("InputsT")


class CommandedWorld(ABC, Generic[InputsT]):
    """The part of a `swarm_sim.ticked_world.TickedWorld` that does not ask what bodies the robots have.

    A subclass says where the antennas are and what robots sense, and moves the bodies: its `advance` begins with
    `_working` and ends with `_begin_tick`.

    Parameters
    ----------
    electronics : Electronics
        Of robots 0 to n - 1, then `MISSION`.
    robots : int
        How many there are, n.
    period_s : float
        Duration of a tick [s].
    """

    def __init__(self, electronics: Electronics, robots: int, period_s: float) -> None:
        self.robots = tuple(NodeId(robot) for robot in range(robots))
        self._electronics = electronics
        self._period_s = period_s
        self._tick = 0
        self._velocities: FloatArray = np.zeros((robots, 3))
        self._observed: Mapping[NodeId, InputsT] | None = None
        self._is_applied = False

    @property
    @abstractmethod
    def _antennas(self) -> FloatArray:
        """Where the radios are, the mission computer's last, (n + 1, d) [m]."""

    @abstractmethod
    def _sense(self) -> Mapping[NodeId, InputsT]:
        """Return what each live robot learns in this tick."""

    @property
    def camera_info(self) -> CameraInfo | None:
        """Return None: nobody looks at these robots from above."""
        return None

    @property
    def tick(self) -> int:
        """Number of the current tick, 0, 1, ..."""
        return self._tick

    @property
    def time(self) -> float:
        """Simulated time at the start of the current tick [s]."""
        return self._tick * self._period_s

    def observe(self) -> Observation[InputsT]:
        """Return what every actor learns in this tick; the same however often it is asked."""
        if self._observed is None:
            self._observed = self._sense()
        mission = MissionInputs(self._tick, self.time, self._electronics.inboxes[-1])
        return Observation(self._tick, self.time, self._observed, mission)

    def apply(self, commands: Mapping[NodeId, FloatArray], outboxes: Mapping[NodeId, tuple[bytes, ...]]) -> None:
        """Hand over what the actors answered in this tick; at most once per tick. Who does not answer stays.

        Raises
        ------
        KeyError
            If an address does not exist.
        RuntimeError
            If called twice in a tick.
        """
        if self._is_applied:
            raise RuntimeError(f"tick {self._tick}: the answers were applied already")
        self._is_applied = True
        for robot, velocity in commands.items():
            if self._electronics.is_alive(robot):
                self._velocities[robot] = velocity
        self._electronics.transmit(self._tick, outboxes, self._antennas)

    def kill(self, node: NodeId) -> None:
        """End a robot's electronics, or the mission computer's radio; raises `KeyError` if it does not exist."""
        if self._electronics.kill(self._tick, node) and self._observed is not None:
            self._observed = {robot: inputs for robot, inputs in self._observed.items() if robot != node}

    def revive(self, node: NodeId) -> None:
        """Switch a robot on, where it stands; raises `KeyError` if it does not exist."""
        if self._electronics.revive(self._tick, node):
            self._observed = None

    def is_on(self, node: NodeId) -> bool:
        """Return whether a node works; raises `KeyError` if it does not exist."""
        return self._electronics.is_alive(node)

    @property
    def links(self) -> tuple[tuple[int, int], ...]:
        """Pairs of robots that can hear each other now."""
        return self._electronics.links(self._antennas).pairs(len(self.robots))

    def take_arrived(self) -> tuple[NodeId, ...]:
        """Return, once, the robots that appeared because the scene says so."""
        return self._electronics.take_arrived()

    def take_died(self) -> tuple[NodeId, ...]:
        """Return, once, the nodes that died because it was appointed, in the order of their deaths."""
        return self._electronics.take_died()

    def _working(self) -> BoolArray:
        """Return whose electronics work in the tick that is about to pass, (n,); nobody's answer is awaited further."""
        if not self._is_applied:
            self.apply({}, {})
        return self._electronics.alive[:-1].copy()

    def _begin_tick(self) -> None:
        self._tick += 1
        self._velocities = np.zeros_like(self._velocities)
        self._electronics.begin(self._tick)
        self._observed, self._is_applied = None, False
