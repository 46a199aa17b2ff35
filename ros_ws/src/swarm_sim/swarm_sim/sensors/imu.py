"""Inertial sensor: mean acceleration over a tick with bias and white noise, heading, turn rate."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.messages.sensing import ImuSample
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import ImuConfig
from swarm_sim.world.world import BodyState


class Imu:
    """The inertial sensors of all robots.

    The mean over the tick is what an integrating sensor hands out; a point sample would miss the short velocity
    transients (erratum E12).

    Parameters
    ----------
    config : ImuConfig
    robots : int
        Number of robots.
    seed : int
        Seed of the run.
    """

    def __init__(self, config: ImuConfig, robots: int, seed: int) -> None:
        self._config = config
        self._seed = seed
        self.bias: FloatArray = rng_for(seed, "imu bias").uniform(-1.0, 1.0, (robots, 2)) * config.bias_max_mps2

    def measure(self, tick: int, bodies: BodyState, mean_accelerations: FloatArray) -> list[ImuSample]:
        """Return one sample per robot.

        Parameters
        ----------
        tick : int
        bodies : BodyState
            At the end of the interval.
        mean_accelerations : (n, 2) array
            Over the interval, world frame [m/s^2].
        """
        rng = rng_for(self._seed, "imu", tick)
        noise = rng.normal(size=(len(self.bias), 3))
        cos, sin = np.cos(bodies.yaws), np.sin(bodies.yaws)
        east, north = mean_accelerations.T
        measured = np.stack([cos * east + sin * north, cos * north - sin * east], axis=1)
        measured += self.bias + self._config.sigma_mps2 * noise[:, :2]
        measured.flags.writeable = False
        yaws = (bodies.yaws + self._config.yaw_sigma_rad * noise[:, 2]).tolist()
        has_compass = self._config.has_compass
        return [
            ImuSample(acceleration, yaw if has_compass else None, rate)
            for acceleration, yaw, rate in zip(measured, yaws, bodies.yaw_rates.tolist(), strict=True)
        ]
