"""Time-of-arrival distances between direct radio neighbors (spec section 4, model `range`)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import IntArray
from swarm_sim.config import RangingConfig
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
        self._every = max(1, round(config.period_s / period_s))
        self._ids = ids
        self._seed = seed

    def measure(self, tick: int, links: LinkTable) -> list[RangeScan]:
        """Return one scan per robot; all are empty in a tick in which no ranging is due.

        Parameters
        ----------
        tick : int
        links : LinkTable
            Links and distances of the radios now, robots first.
        """
        n = len(self._ids)
        if tick % self._every:
            return [_NO_SCAN] * n
        noise = rng_for(self._seed, "ranging", tick).normal(size=(n, n))
        # A range is a measured delay, so noise cannot make it negative.
        ranges = np.maximum(links.distances[:n, :n] + self._config.sigma_m * noise, 0.0)
        rows, columns = np.nonzero(links.connected[:n, :n])
        cuts = np.searchsorted(rows, np.arange(n + 1)).tolist()
        ids, values = self._ids[columns], ranges[rows, columns]
        ids.flags.writeable = values.flags.writeable = False
        return [RangeScan(ids[a:b], values[a:b]) for a, b in pairwise(cuts)]
