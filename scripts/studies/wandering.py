"""Random motion about a place, so that a study of localization can show whether motion matters."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray

RADIUS_M = 3.0  # of the disk around its home in which a robot wanders: the swarm keeps its shape, roughly
SPEED_MIN_MPS, SPEED_MAX_MPS = 0.1, 0.5  # top speed of the thesis
LEG_MIN_S, LEG_MAX_S = 1.0, 6.0  # between two changes of mind


class Wandering:
    """Every robot drives to a random point near its home, and to another one after a while.

    Robots pass through each other (the light physics has no contacts); nothing here is about collisions.

    Parameters
    ----------
    homes : (n, 2) array
        Centers of the disks [m].
    period_s : float
        Control period [s].
    seed : int
        Seed of the run.
    """

    def __init__(self, homes: FloatArray, period_s: float, seed: int) -> None:
        self._homes = homes
        self._period = period_s
        self._rng = rng_for(seed, "wandering")
        self._targets, self._speeds = homes.copy(), np.zeros(len(homes))
        self._left = np.zeros(len(homes))  # time until the next change of mind [s]

    def step(self, positions: FloatArray, yaws: FloatArray) -> list[VelocityCommand]:
        """Return the next command of each robot.

        Parameters
        ----------
        positions : (n, 2) array
            True positions now [m].
        yaws : (n,) array
            True headings now [rad].
        """
        n = len(positions)
        # Drawn for all robots at each step: the change of one does not shift the numbers of another.
        angle, radius, speed, leg = self._rng.uniform(size=(4, n))
        is_over = self._left <= 0.0
        offsets = np.stack([np.cos(2.0 * np.pi * angle), np.sin(2.0 * np.pi * angle)], axis=1)
        offsets *= RADIUS_M * np.sqrt(radius)[:, None]
        self._targets = np.where(is_over[:, None], self._homes + offsets, self._targets)
        self._speeds = np.where(is_over, SPEED_MIN_MPS + (SPEED_MAX_MPS - SPEED_MIN_MPS) * speed, self._speeds)
        self._left = np.where(is_over, LEG_MIN_S + (LEG_MAX_S - LEG_MIN_S) * leg, self._left) - self._period
        ahead = self._targets - positions
        distances = np.hypot(ahead[:, 0], ahead[:, 1])
        # Slower at the end, so that a robot arrives instead of swinging around its target.
        pace = np.minimum(self._speeds / np.maximum(distances, np.finfo(np.float64).tiny), 0.5 / self._period)
        east, north = (ahead * pace[:, None]).T
        cos, sin = np.cos(yaws), np.sin(yaws)
        forward, left = (cos * east + sin * north).tolist(), (cos * north - sin * east).tolist()
        return [VelocityCommand(f, side, 0.0) for f, side in zip(forward, left, strict=True)]
