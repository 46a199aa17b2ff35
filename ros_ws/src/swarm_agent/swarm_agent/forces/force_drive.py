"""From forces to velocities: the robots' own motion over a control period, predicted in steps that the law can bear."""

from __future__ import annotations

import math

import numpy as np

from swarm_agent.forces.config import ForceConfig
from swarm_agent.forces.force_law import ForceLaw, Others
from swarm_msgs_py.types import BoolArray, FloatArray

_TINY = 1e-12
_REST_SIGMAS, _WAKE_SIGMAS = 1.0, 4.0
"""Speeds per standard deviation of the position [1/s] below which resting and starting again would follow its noise:
both laws answer a displacement of a meter with about 1 m/s."""
_REST_SHARE, _WAKE_SHARE = 0.25, 0.75
"""Shares of the top speed that those speeds do not exceed: however unsure a robot is, far from its place it drives."""


class ForceDrive:
    """Velocities of n robots under a force law; n is 1 on a robot.

    A velocity that holds for a whole control period may carry a robot far beyond where its force would have turned
    round. So the drive moves each robot in thought, in short steps and with its neighbors keeping the velocity they
    told, and commands the mean velocity of that motion. A robot that is driven slowly rests until it is driven faster.

    Parameters
    ----------
    config : ForceConfig
    period_s : float
        Control period [s].
    count : int
        Number of robots n.
    """

    def __init__(self, config: ForceConfig, period_s: float, count: int = 1) -> None:
        self._config = config
        self._period = period_s
        self._resting: BoolArray = np.zeros(count, dtype=np.bool_)

    @property
    def resting(self) -> BoolArray:
        """Which robots rest, (n,)."""
        return self._resting

    def step(  # noqa: PLR0913, PLR0917 - two sides of an encounter
        self,
        law: ForceLaw,
        positions: FloatArray,
        radii: FloatArray,
        others: Others,
        drifts: FloatArray,
        sigma: float = 0.0,
    ) -> FloatArray:
        """Return the velocities to command.

        Parameters
        ----------
        law : ForceLaw
        positions : (n, 2) array
            Of the robots that are driven [m].
        radii : (n,) array
            Their coverage radii [m].
        others : Others
            Whom they react to, as they are now.
        drifts : (m, 2) array
            Velocities of the others [m/s].
        sigma : float
            Standard deviation of the positions, per axis [m]; forces that only follow its noise move nobody.

        Returns
        -------
        (n, 2) array
            World frame, at most `speed_max_m_s` long [m/s].
        """
        steps = math.ceil(self._period / law.step_max - _TINY)
        pause = self._period / steps
        places = positions
        for step in range(steps):
            moved = others.positions + step * pause * drifts if step else others.positions
            around = Others(moved, others.radii, others.heard)
            places = places + pause * self._velocities(law.evaluate(places, radii, around))
        mean = (places - positions) / self._period
        speeds = np.hypot(mean[:, 0], mean[:, 1])
        top = self._config.speed_max_m_s
        rest = max(self._config.rest_m_s, min(_REST_SIGMAS * sigma, _REST_SHARE * top))
        wake = max(self._config.wake_m_s, min(_WAKE_SIGMAS * sigma, _WAKE_SHARE * top))
        self._resting = speeds < np.where(self._resting, wake, rest)
        velocities: FloatArray = np.where(self._resting[:, None], 0.0, mean)
        return velocities

    def _velocities(self, forces: FloatArray) -> FloatArray:
        """Return v = v_max F / max(abs(F), F_sat), (n, 2) (spec section 8.2)."""
        sizes = np.hypot(forces[:, 0], forces[:, 1])
        scaled: FloatArray = forces * (self._config.speed_max_m_s / np.maximum(sizes, self._config.f_sat))[:, None]
        return scaled
