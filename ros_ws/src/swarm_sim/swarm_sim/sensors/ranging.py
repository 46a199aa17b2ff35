"""Time-of-arrival distances between direct radio neighbors, with one of the two noise models of spec section 4."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, IntArray
from swarm_sim.config import RangingConfig, RangingModel
from swarm_sim.radio.links import LinkTable

_NO_SCAN = RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0))
_NO_SCAN.neighbors.flags.writeable = _NO_SCAN.ranges.flags.writeable = False


class Ranging:
    """The ranging radios of all robots; the mission computer's antenna does not range.

    Parameters
    ----------
    config : RangingConfig
    ids : (n,) int array
        Addresses of the robots, ascending.
    period_s : float
        Control period [s].
    seed : int
        Seed of the run.
    """

    def __init__(self, config: RangingConfig, ids: IntArray, period_s: float, seed: int) -> None:
        self._config = config
        self._every = max(1, round((config.period_s or 0.0) / period_s))
        self._ids = ids
        self._seed = seed

    def measure(self, tick: int, positions: FloatArray, links: LinkTable) -> list[RangeScan]:
        """Return one scan per robot; all are empty in a tick in which no ranging is due.

        Parameters
        ----------
        tick : int
        positions : (n, 2) array
            Of the robots, now [m].
        links : LinkTable
            Links and distances of the radios now, robots first.
        """
        n = len(self._ids)
        if not self._config.is_on or tick % self._every:
            return [_NO_SCAN] * n
        rows, columns = np.nonzero(links.connected[:n, :n])
        if self._config.model is RangingModel.POSITION:
            values = self._ranges_from_noisy_points(tick, positions, rows, columns)
        else:
            values = self._noisy_ranges(tick, links.distances[rows, columns], rows, columns)
        cuts = np.searchsorted(rows, np.arange(n + 1)).tolist()
        ids = self._ids[columns]
        ids.flags.writeable = values.flags.writeable = False
        return [RangeScan(ids[a:b], values[a:b]) for a, b in pairwise(cuts)]

    # Both draw for all robots, or pairs of them, whether linked or not: no link shifts the noise of another.

    def _noisy_ranges(self, tick: int, distances: FloatArray, rows: IntArray, columns: IntArray) -> FloatArray:
        """Return the distances (k,) with independent noise; the two ends of a link measure apart."""
        n = len(self._ids)
        noise = rng_for(self._seed, "ranging", tick).normal(size=(n, n))[rows, columns]
        # A range is a measured delay, so noise cannot make it negative.
        values: FloatArray = np.maximum(distances + self._config.sigma_m * noise, 0.0)
        return values

    def _ranges_from_noisy_points(
        self, tick: int, positions: FloatArray, rows: IntArray, columns: IntArray
    ) -> FloatArray:
        """Return the distances (k,) of the neighbors from where the noise displaced each robot to."""
        noise = rng_for(self._seed, "ranging from", tick).normal(size=positions.shape)
        x, y = ((positions + self._config.sigma_m * noise)[rows] - positions[columns]).T
        values: FloatArray = np.hypot(x, y)
        return values
