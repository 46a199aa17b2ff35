"""Wind and waves on boats: forces that no controller is told.

Wind pushes all boats alike; gusts are first-order noise of each boat; waves are a few plane waves of deep water, whose
force on a boat depends on where it floats and when.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import WaterConfig
from swarm_sim.gravity import GRAVITY

WAVES = 4
SPREAD_RAD = 0.5
"""Standard deviation of the waves' directions about the wind's [rad]."""
PERIOD_SPREAD = (0.7, 1.4)
"""Least and largest period of a wave, relative to that of the highest."""
BLOCK_STEPS = 256
"""Steps for which noise is drawn at once."""


class NoiseBlocks:
    """White noise of unit variance, a row per stream and step, the same however many rows there are.

    Parameters
    ----------
    streams : sequence of Generator
    width : int
        Numbers per row and step.
    """

    def __init__(self, streams: Sequence[np.random.Generator], width: int) -> None:
        self._streams = streams
        self._shape = (BLOCK_STEPS, width)
        self._block = np.empty((BLOCK_STEPS, len(streams), width))
        self._next = BLOCK_STEPS

    def draw(self) -> FloatArray:
        """Return the next numbers (n, width)."""
        if self._next == BLOCK_STEPS:
            for row, stream in enumerate(self._streams):
                self._block[:, row] = stream.standard_normal(self._shape)
            self._next = 0
        self._next += 1
        numbers: FloatArray = self._block[self._next - 1]
        return numbers


class Water:
    """Disturbing wrenches on boats.

    Parameters
    ----------
    config : WaterConfig
    pools : sequence of int
        Seed of the pool that each boat floats in: boats with equal numbers share wind and waves.
    boats : sequence of int
        Number of each boat, for its own gusts.
    step_s : float
        Time between two calls [s].
    """

    def __init__(self, config: WaterConfig, pools: Sequence[int], boats: Sequence[int], step_s: float) -> None:
        self._step_s = step_s
        self._time = 0.0
        weather = {pool: _Weather(config, pool) for pool in sorted(set(pools))}
        rows = [weather[pool] for pool in pools]
        self._wind = np.stack([one.wind for one in rows])
        self._pulls = np.stack([one.pulls for one in rows])  # (n, w, 3)
        self._wave_vectors = np.stack([one.wave_vectors for one in rows])  # (n, w, 2)
        self._rates = np.stack([one.rates for one in rows])  # (n, w)
        self._phases = np.stack([one.phases for one in rows])
        self._decay = float(np.exp(-step_s / config.gust_s))
        self._sigma = np.array([config.gust_n / np.sqrt(2.0)] * 2 + [config.gust_yaw_nm])
        streams = [rng_for(pool, "gusts", boat) for pool, boat in zip(pools, boats, strict=True)]
        self._noise = NoiseBlocks(streams, 3)
        self._gusts = self._sigma * self._noise.draw()

    def wrenches(self, poses: FloatArray) -> FloatArray:
        """Return the forces [N] and yaw moments [N m] of the next step, world frame.

        Parameters
        ----------
        poses : (n, 3) array
        """
        phase = np.einsum("nwi,ni->nw", self._wave_vectors, poses[:, :2]) - self._rates * self._time + self._phases
        waves = np.einsum("nw,nwi->ni", np.sin(phase), self._pulls)
        total = waves + self._gusts
        total[:, :2] += self._wind
        spread = np.sqrt(1.0 - self._decay**2)
        self._gusts = self._decay * self._gusts + spread * self._sigma * self._noise.draw()
        self._time += self._step_s
        return np.asarray(total)


class _Weather:
    """Wind and waves of one pool."""

    def __init__(self, config: WaterConfig, pool: int) -> None:
        rng = rng_for(pool, "weather")
        direction = rng.uniform(-np.pi, np.pi)
        self.wind = config.wind_n * np.array([np.cos(direction), np.sin(direction)])
        ways = direction + SPREAD_RAD * rng.standard_normal(WAVES)
        headings = np.column_stack([np.cos(ways), np.sin(ways)])
        periods = config.wave_period_s * np.geomspace(*PERIOD_SPREAD, WAVES)
        self.rates = 2.0 * np.pi / periods
        self.wave_vectors = (self.rates**2 / GRAVITY)[:, None] * headings  # deep water
        self.phases = rng.uniform(-np.pi, np.pi, WAVES)
        # Equal shares of the variance: a sine of amplitude A has the root mean square A / sqrt(2).
        share = np.sqrt(2.0 / WAVES)
        yaw = config.wave_yaw_nm * rng.choice([-1.0, 1.0], WAVES)
        self.pulls = share * np.column_stack([config.wave_n * headings, yaw])
