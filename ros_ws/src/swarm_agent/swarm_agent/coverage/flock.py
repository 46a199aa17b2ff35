"""How far a formation that moves has come (spec section 8)."""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.frames import Mission
from swarm_msgs_py.types import FloatArray


class Flock:
    """The frame in which the board's places and the shape stand still; it moves as the missions say.

    Parameters
    ----------
    period : float
        Of a tick [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._origin: FloatArray = np.zeros(3)
        self._since = 0
        self._velocity = (0.0, 0.0, 0.0)

    def follow(self, mission: Mission) -> None:
        """Take the velocity of a mission; it holds from the tick on that the mission names."""
        if mission.velocity != self._velocity:
            self._origin = self.shift(mission.since)
            self._since, self._velocity = mission.since, mission.velocity

    def shift(self, tick: int) -> FloatArray:
        """Return how far the frame has moved by a tick, (3,) [m]."""
        shift: FloatArray = self._origin + np.array(self._velocity) * (self._period * max(0, tick - self._since))
        return shift

    def drift(self, tick: int) -> FloatArray:
        """Return the velocity of the frame in a tick, (3,) [m/s]."""
        return np.array(self._velocity) if tick >= self._since else np.zeros(3)
