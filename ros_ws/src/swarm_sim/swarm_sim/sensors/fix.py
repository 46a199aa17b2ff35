"""Position sensor of the robots that carry one."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.messages.sensing import PositionFix
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import FixConfig


class PositionSensor:
    """The position sensors of all robots.

    Parameters
    ----------
    config : FixConfig
    carried : (n,) bool array
        Who carries one.
    seed : int
        Seed of the run.
    """

    def __init__(self, config: FixConfig, carried: np.ndarray[tuple[int], np.dtype[np.bool_]], seed: int) -> None:
        self._config = config
        self._carried = carried.tolist()
        self._seed = seed

    def measure(self, tick: int, positions: FloatArray) -> list[PositionFix | None]:
        """Return one fix per robot at `positions` (n, 2) [m], None for those without a sensor."""
        # Drawn for all robots, so that giving one a sensor changes nothing for the others.
        noise = rng_for(self._seed, "fix", tick).normal(size=positions.shape)
        measured = positions + self._config.sigma_m * noise
        measured.flags.writeable = False
        sigma = self._config.sigma_m
        return [
            PositionFix(point, sigma) if has_sensor else None
            for point, has_sensor in zip(measured, self._carried, strict=True)
        ]
