"""A robot's heading: by its compass, or by what it told its wheels, corrected by who sees it from outside."""

from __future__ import annotations

import math

import numpy as np

from swarm_agent.localization.camera_fixes import AGE_TICKS_MAX, SeenFrom, Trail
from swarm_agent.localization.config import LpsConfig


class Heading:
    """Kalman filter of one angle; innovations are taken the short way around.

    Parameters
    ----------
    config : LpsConfig
    period_s : float
        Control period [s].
    """

    def __init__(self, config: LpsConfig, period_s: float) -> None:
        self._config, self._period = config, period_s
        self._variance = 0.0
        self._trail = Trail(AGE_TICKS_MAX)
        self._doubts = 0  # headings in a row that did not fit
        self._tick: int | None = None
        self.yaw: float | None = None
        """Heading [rad]; None as long as nobody has told it."""

    @property
    def sigma(self) -> float:
        """Standard deviation of a heading that is reckoned, 0 for one by the compass [rad]."""
        return math.sqrt(self._variance)

    def step(self, tick: int, compass: float | None, turn_rate: float, seen: SeenFrom | None) -> float | None:
        """Return the heading at a tick [rad], None if it is not known.

        Parameters
        ----------
        tick : int
        compass : float or None
            What the magnetometer says [rad], if there is one; then nothing else counts.
        turn_rate : float
            That the robot was told to turn at in the tick that ends now [rad/s].
        seen : SeenFrom or None
            What somebody saw, now or some ticks ago.
        """
        ticks = 1 if self._tick is None else tick - self._tick
        self._tick = tick
        if compass is not None:
            self.yaw, self._variance = compass, 0.0
            return compass
        self._reckon(tick, ticks, turn_rate)
        if seen is not None:
            since = float(self._trail.since(seen.tick).sum())
            age_s = (tick - seen.tick) * self._period
            variance = seen.fix.yaw_sigma**2 + (age_s * self._config.turn_sigma_rps) ** 2
            self._correct(seen.fix.yaw + since, variance)
        return self.yaw

    def _reckon(self, tick: int, ticks: int, turn_rate: float) -> None:
        """Turn by what was told; of ticks that were missed nothing is known but that the robot then stood."""
        turned = turn_rate * self._period
        self._trail.note(tick, np.array([turned]))
        if self.yaw is not None:
            self.yaw = math.remainder(self.yaw + turned, math.tau)
            self._variance += (ticks * self._period * self._config.turn_sigma_rps) ** 2

    def _correct(self, measured: float, variance: float) -> None:
        if self.yaw is None:
            self.yaw, self._variance = math.remainder(measured, math.tau), variance
            return
        off = math.remainder(measured - self.yaw, math.tau)
        total = self._variance + variance
        if off * off > self._config.range_gate_chi_square * total:
            self._doubts += 1
            if self._doubts >= self._config.rejections_max:
                self.yaw, self._variance, self._doubts = math.remainder(measured, math.tau), variance, 0
            return
        self._doubts = 0
        self.yaw = math.remainder(self.yaw + self._variance / total * off, math.tau)
        self._variance *= variance / total
