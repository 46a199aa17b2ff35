"""Edges of polygons as points see them: the coordinates in which line integrals along them have closed forms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_msgs_py.types import FloatArray


class Edges:
    """All edges of some closed polygons, in one list.

    Parameters
    ----------
    polygons : sequence of (k, 2) array
        Corners [m]. Edges without length are left out.

    Attributes
    ----------
    lengths : (e,) array
        [m].
    tangents, normals : (e, 2) array
        Unit vectors along each edge, and to its left.
    """

    def __init__(self, polygons: Sequence[FloatArray]) -> None:
        tails = np.concatenate([*polygons, np.empty((0, 2))])
        heads = np.concatenate([*(np.roll(polygon, -1, axis=0) for polygon in polygons), np.empty((0, 2))])
        lengths = np.linalg.norm(heads - tails, axis=1)
        proper = lengths > 0.0
        self.lengths: FloatArray = lengths[proper]
        self.tangents: FloatArray = (heads - tails)[proper] / self.lengths[:, None]
        self.normals: FloatArray = np.column_stack([-self.tangents[:, 1], self.tangents[:, 0]])
        # Both axes of all edges in one array: one product serves a point, and small products cost by their number.
        self._axes: FloatArray = np.concatenate([self.tangents, self.normals]).T.copy()
        tails = tails[proper]
        self._tails: FloatArray = np.concatenate([(tails * axes).sum(axis=1) for axes in (self.tangents, self.normals)])

    def seen_from(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where each edge lies, seen from each point.

        Parameters
        ----------
        points : (n, 2) array
            [m].

        Returns
        -------
        first : (n, e) array
            Coordinate of the edge's tail along its tangent, the point being the origin [m].
        heights : (n, e) array
            Coordinate of its line along the normal [m].
        """
        # Matrix products round differently from one kind of processor to the next, and einsum does not.
        seen = np.einsum("nd,de->ne", points, self._axes)
        np.subtract(self._tails, seen, out=seen)
        count = len(self.lengths)
        return seen[:, :count], seen[:, count:]
