"""How far a formation that moves has come (spec section 8)."""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import Mission
from swarm_msgs_py.types import FloatArray

SHAKEN_SIGMAS = 7.0  # of noise that a link of a moving formation bears: five of both ends together


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
        self._since, self._velocity = 0, np.zeros(3)
        self._before: FloatArray = np.zeros(3)  # velocity until then

    def follow(self, mission: Mission) -> None:
        """Take the velocity of a mission; it holds from the tick on that the mission names, the old one until then."""
        if (mission.since, *mission.velocity) != (self._since, *self._velocity.tolist()):
            self._origin = self.shift(mission.since)
            self._before = self.drift(mission.since)
            self._since, self._velocity = mission.since, np.array(mission.velocity)

    def shift(self, tick: int) -> FloatArray:
        """Return how far the frame has moved by a tick, (3,) [m]."""
        velocity = self._velocity if tick >= self._since else self._before
        shift: FloatArray = self._origin + velocity * (self._period * (tick - self._since))
        return shift

    def drift(self, tick: int) -> FloatArray:
        """Return the velocity of the frame in a tick, (3,) [m/s]."""
        return self._velocity if tick >= self._since else self._before

    def contraction(self, tick: int, config: CoverageConfig) -> float:
        """Return how large the formation is to be in a tick, 1 at rest, so that its longest links bear the noise."""
        if not self.drift(tick).any():
            return 1.0
        room = config.range_m - SHAKEN_SIGMAS * config.motion.sigma_m
        return min(1.0, room / (config.placement * config.range_m))
