"""Who hears whom: range and line of sight (spec section 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import FloatArray
from swarm_sim.config import RadioConfig, RadioModel
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

    def pairs(self, count: int) -> tuple[tuple[int, int], ...]:
        """Return who is linked among the first `count` radios, each pair once."""
        first, second = np.nonzero(np.triu(self.connected[:count, :count], 1))
        return tuple(zip(first.tolist(), second.tolist(), strict=True))


class Links(Protocol):
    """Who hears whom, by where they are."""

    def evaluate(self, positions: FloatArray, alive: NDArray[np.bool_]) -> LinkTable:
        """Return the links of radios at `positions` (n, 2) [m] of which `alive` (n,) are on."""
        ...


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
        distances = _distances(positions)
        first, second = np.nonzero(np.triu((distances < self._range) & alive & alive[:, None], k=1))
        is_free = ~self._obstacles.is_blocked(positions[first], positions[second])
        connected = np.zeros(distances.shape, dtype=np.bool_)
        connected[first, second] = connected[second, first] = is_free
        return LinkTable(connected, distances)


class EverybodyHears:
    """Any two live radios hear each other."""

    def evaluate(self, positions: FloatArray, alive: NDArray[np.bool_]) -> LinkTable:
        """Return the links of radios at `positions` (n, 2) [m] of which `alive` (n,) are on."""
        connected = alive & alive[:, None]
        np.fill_diagonal(connected, val=False)
        return LinkTable(connected, _distances(positions))


def make_links(config: RadioConfig, obstacles: ObstacleField) -> Links:
    """Return the links that the settings ask for."""
    return EverybodyHears() if config.model is RadioModel.IDEAL else LinkModel(config.range_m, obstacles)


def _distances(positions: FloatArray) -> FloatArray:
    """Return the distances between all positions, (n, n) [m]."""
    x, y = positions.T
    distances: FloatArray = np.hypot(x[:, None] - x, y[:, None] - y)
    return distances
