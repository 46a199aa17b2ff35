"""Which way a robot faces: as ordered, or as it did."""

from __future__ import annotations

import math

from swarm_agent.control.config import ControlConfig


class Facing:
    """Turns the robot to a heading, and holds it there.

    Parameters
    ----------
    config : ControlConfig
    """

    def __init__(self, config: ControlConfig) -> None:
        self._gain, self._turn_max = config.heading_gain_1_s, config.turn_max_rps
        self._wanted = None if config.heading_deg is None else math.radians(config.heading_deg)

    def turn_rate(self, yaw: float, ordered: float | None) -> float:
        """Return how fast to turn, counter-clockwise [rad/s].

        Parameters
        ----------
        yaw : float
            Heading now [rad].
        ordered : float or None
            Heading that the plan orders [rad]; None: the last one that was ordered, or the first that the robot had.
        """
        if ordered is not None:
            self._wanted = ordered
        if self._wanted is None:
            self._wanted = yaw
        rate = -self._gain * math.remainder(yaw - self._wanted, math.tau)
        return min(max(rate, -self._turn_max), self._turn_max)
