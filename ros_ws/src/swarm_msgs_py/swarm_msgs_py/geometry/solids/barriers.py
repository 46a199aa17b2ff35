"""Obstacles in space: which segments they cut. They block links, sight and motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

STEP_M = 0.5  # between the points of a segment that are looked at: a thinner edge of an obstacle may be passed over


class Barriers:
    """Solids that nobody sees, hears or moves through.

    A segment counts as cut if one of its points, `STEP_M` apart at most, is in a solid. That holds for every solid that
    can tell inside from outside, and a wall must be thicker than `STEP_M` to be one.

    Parameters
    ----------
    solids : sequence of Solid
    """

    def __init__(self, solids: Sequence[Solid] = ()) -> None:
        self._solids = tuple(solids)

    def __bool__(self) -> bool:
        return bool(self._solids)

    def contain(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are in an obstacle, (n,)."""
        inside = np.zeros(len(points), dtype=np.bool_)
        for solid in self._solids:
            inside |= solid.contains(points)
        return inside

    def pairs_in_sight(self, points: FloatArray, reach: float) -> IntArray:
        """Return the pairs of `points` (n, 3) that are no farther apart than `reach` [m] and not cut, (m, 2) rows."""
        pairs: IntArray = cKDTree(points).query_pairs(reach, output_type="ndarray")
        return pairs[~self.cut(points[pairs[:, 0]], points[pairs[:, 1]])] if self else pairs

    def cut(self, tails: FloatArray, heads: FloatArray) -> BoolArray:
        """Return which segments from `tails` to `heads`, both (n, 3) [m], an obstacle cuts, (n,)."""
        is_cut = np.zeros(len(tails), dtype=np.bool_)
        for solid in self._solids:
            low, high = solid.bounds
            may = ~is_cut & np.all((np.minimum(tails, heads) <= high) & (np.maximum(tails, heads) >= low), axis=1)
            rows = np.flatnonzero(may)
            if not len(rows):
                continue
            steps = heads[rows] - tails[rows]
            count = int(np.ceil(np.sqrt(np.einsum("ij,ij->i", steps, steps).max()) / STEP_M)) + 1
            shares = np.linspace(0.0, 1.0, max(count, 2))
            points = tails[rows, None] + shares[:, None] * steps[:, None]
            is_cut[rows] = solid.contains(points.reshape(-1, 3)).reshape(len(rows), -1).any(axis=1)
        return is_cut


OPEN_SPACE = Barriers()
"""Nothing in the way."""
