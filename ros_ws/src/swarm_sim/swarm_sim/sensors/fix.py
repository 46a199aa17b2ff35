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
        sigma, measured = self._config.sigma_m, positions.copy()
        if sigma > 0.0:
            # Drawn for all robots, so that giving one a sensor changes nothing for the others.
            measured += sigma * rng_for(self._seed, "fix", tick).normal(size=positions.shape)
        measured.flags.writeable = False
        return [
            PositionFix(point, sigma) if has_sensor else None
            for point, has_sensor in zip(measured, self._carried, strict=True)
        ]
