"""Who hears whom in space: range and line of sight."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from swarm_msgs_py.geometry.solids.barriers import Barriers
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import RadioConfig, RadioModel
from swarm_sim.radio.links import LinkTable


class SpaceLinks:
    """Two live radios hear each other if they are strictly closer than the range and no obstacle is between them.

    Parameters
    ----------
    radio : RadioConfig
        Its ideal model lets everybody hear everybody.
    barriers : Barriers
    """

    def __init__(self, radio: RadioConfig, barriers: Barriers) -> None:
        self._range = np.inf if radio.model is RadioModel.IDEAL else radio.range_m
        self._barriers = Barriers() if radio.model is RadioModel.IDEAL else barriers

    def evaluate(self, positions: FloatArray, alive: NDArray[np.bool_]) -> LinkTable:
        """Return the links of radios at `positions` (n, 3) [m] of which `alive` (n,) are on."""
        distances: FloatArray = cdist(positions, positions)
        connected = (distances < self._range) & alive & alive[:, None]
        np.fill_diagonal(connected, val=False)
        if self._barriers:
            first, second = np.nonzero(np.triu(connected))
            is_free = ~self._barriers.cut(positions[first], positions[second])
            connected[first, second] = connected[second, first] = is_free
        return LinkTable(connected, distances)
