"""Who hears whom: range and line of sight (spec section 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import FloatArray
from swarm_sim.world.obstacles import ObstacleField


@dataclass(frozen=True, slots=True, eq=False)
class LinkTable:
    """All links at one instant, between radios in ascending order of address.

    Attributes
    ----------
    connected : (n, n) bool array
        Symmetric, False on the diagonal; a dead radio has no link.
    distances : (n, n) array
        Between the antennas [m].
    """

    connected: NDArray[np.bool_]
    distances: FloatArray


class LinkModel:
    """Two live radios hear each other if they are closer than the range and no obstacle is between them.

    Parameters
    ----------
    range_m : float
        Radio range [m].
    obstacles : ObstacleField
    """

    def __init__(self, range_m: float, obstacles: ObstacleField) -> None:
        self._range = range_m
        self._obstacles = obstacles

    def evaluate(self, positions: FloatArray, alive: NDArray[np.bool_]) -> LinkTable:
        """Return the links of radios at `positions` (n, 2) [m] of which `alive` (n,) are on."""
        x, y = positions.T
        distances = np.hypot(x[:, None] - x, y[:, None] - y)
        first, second = np.nonzero(np.triu((distances < self._range) & alive & alive[:, None], k=1))
        is_free = ~self._obstacles.is_blocked(positions[first], positions[second])
        connected = np.zeros(distances.shape, dtype=np.bool_)
        connected[first, second] = connected[second, first] = is_free
        return LinkTable(connected, distances)
