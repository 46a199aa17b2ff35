"""Does a straight motion cross a wall? The one inner loop of the planner, as a few matrix products.

All segments of a query leave one point. For them the sign tests of the textbook segment intersection are products
of an (n, 2) matrix with a (2, e) matrix, which is far faster than a geometry library called once per segment.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import FloatArray


class Walls:
    """Closed outlines that a straight motion may not cross.

    Parameters
    ----------
    rings : tuple of (k, 2) array
        Simple polygons without common points; together they bound the solid [m].
    """

    def __init__(self, rings: tuple[FloatArray, ...]) -> None:
        closed = [np.vstack((ring, ring[:1])) for ring in rings]
        corners = np.concatenate([*closed, np.empty((0, 2))])
        edges = np.diff(corners, axis=0)
        # All rings stand in one list, so that the slices [:-1] and [1:] are the ends of the edges. The false edge
        # between two rings gets a zero normal: then both ends of every segment count as on the same side of it.
        edges[np.cumsum([len(ring) for ring in closed], dtype=np.int64)[:-1] - 1] = 0.0
        self._turned = np.ascontiguousarray(np.stack((corners[:, 1], -corners[:, 0])))
        self._heights = np.ascontiguousarray(corners[:, 1])
        self._normals = np.ascontiguousarray(np.stack((-edges[:, 1], edges[:, 0])))
        self._offsets = (corners[:-1] * self._normals.T).sum(axis=1)
        self._climbs = edges[:, 1] != 0.0
        self._boxes = [(*ring.min(axis=0).tolist(), *ring.max(axis=0).tolist()) for ring in rings]

    def clear_from(self, origin: FloatArray, ends: FloatArray) -> NDArray[np.bool_]:
        """Return which segments from one point cross no wall.

        Parameters
        ----------
        origin : (2,) array
            Outside of the solid [m].
        ends : (n, 2) array
            Other ends of the segments [m]. An end inside the solid is never clear.

        Returns
        -------
        (n,) array of bool
        """
        if not self._boxes:
            return np.ones(len(ends), dtype=np.bool_)
        ways = ends - origin
        # An edge is crossed if its ends are on two sides of the segment's line, and the segment's ends are on two sides
        # of the edge's line. Zero counts as right in both tests, so a line through a corner meets one edge, not none.
        height_of_origin = ways[:, :1] * origin[1] - ways[:, 1:] * origin[0]
        left_of_way = ways @ self._turned > height_of_origin
        here = origin @ self._normals - self._offsets
        crossed = ((ways @ self._normals + here) > 0.0) != (here > 0.0)
        crossed &= left_of_way[:, 1:] != left_of_way[:, :-1]
        clear: NDArray[np.bool_] = ~crossed.any(axis=1)
        return clear

    def is_clear(self, origin: FloatArray, end: FloatArray) -> bool:
        """Return whether one segment crosses no wall; `origin` must be outside of the solid."""
        x0, y0 = origin.tolist()
        x1, y1 = end.tolist()
        if not self._box_meets(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)):
            return True
        way = end - origin
        left_of_way = way @ self._turned > (x1 - x0) * y0 - (y1 - y0) * x0
        here = origin @ self._normals - self._offsets
        crossed = ((way @ self._normals + here) > 0.0) != (here > 0.0)
        crossed &= left_of_way[1:] != left_of_way[:-1]
        return not crossed.any()

    def enclose(self, x: float, y: float) -> bool:
        """Return whether a point lies inside the solid, by counting the edges that a ray to the right meets."""
        if not self._box_meets(x, y, x, y):
            return False
        above = self._heights > y
        left_of_edge = (x * self._normals[0] + y * self._normals[1]) > self._offsets
        meets = (above[1:] != above[:-1]) & (left_of_edge == above[1:]) & self._climbs
        return bool(np.count_nonzero(meets) % 2)

    def _box_meets(self, left: float, bottom: float, right: float, top: float) -> bool:
        for x0, y0, x1, y1 in self._boxes:  # noqa: SIM110 - a generator costs more than the whole loop
            if left <= x1 and x0 <= right and bottom <= y1 and y0 <= top:
                return True
        return False
