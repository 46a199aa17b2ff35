"""Does a straight motion cross a wall? The one inner loop of the planner, as a few matrix products.

All segments of a query leave one point. For them the sign tests of the textbook segment intersection are products
of an (n, 2) matrix with a (2, e) matrix, which is far faster than a geometry library called once per segment.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import FloatArray

SLACK = 1e-9
"""Boxes are larger than what they hold by this [m]: far more than a rounding, far less than a path may graze a wall."""

_Box = tuple[float, float, float, float]
"""Axis-parallel box around a ring or an edge: center, half width, half height [m]."""


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
        self._normals = np.ascontiguousarray(np.stack((-edges[:, 1], edges[:, 0])))
        self._offsets = (corners[:-1] * self._normals.T).sum(axis=1)
        heights = corners[:, 1]
        table = np.column_stack((heights[:-1], heights[1:], self._normals.T, self._offsets)).tolist()
        starts = np.cumsum([0, *map(len, closed)]).tolist()
        # Of every ring its box, those of its edges, and its edges: heights of both ends, normal, offset.
        self._boxes = [_boxes(ring[None])[0] for ring in closed]
        self._edge_boxes = [_boxes(np.stack((ring[:-1], ring[1:]), axis=1)) for ring in closed]
        self._edges = [table[start : end - 1] for start, end in pairwise(starts)]

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
        if not self._may_meet(x0, y0, x1 - x0, y1 - y0):
            return True
        way = end - origin
        left_of_way = way.dot(self._turned) > (x1 - x0) * y0 - (y1 - y0) * x0
        here = origin.dot(self._normals) - self._offsets
        crossed = ((way.dot(self._normals) + here) > 0.0) != (here > 0.0)
        crossed &= left_of_way[1:] != left_of_way[:-1]
        return not crossed.any()

    def enclose(self, x: float, y: float) -> bool:
        """Return whether a point lies inside the solid, by counting the edges that a ray to the right meets."""
        is_inside = False
        for ring in _met(self._boxes, x, y, 0.0, 0.0):
            for tail, head, normal_x, normal_y, offset in self._edges[ring]:
                is_above = head > y
                if (tail > y) != is_above and (x * normal_x + y * normal_y > offset) == is_above:
                    is_inside = not is_inside
        return is_inside

    def _may_meet(self, x: float, y: float, ahead: float, aside: float) -> bool:
        """Return whether a segment from (x, y) by (ahead, aside) meets the box of an edge.

        Everything is in the box of the fence around an arena; therefore every edge has a box of its own.
        """
        rings = _met(self._boxes, x, y, ahead, aside)
        return any(_met(self._edge_boxes[ring], x, y, ahead, aside) for ring in rings)


def _boxes(groups: FloatArray) -> list[_Box]:
    """Return the smallest boxes around groups of points, (m, k, 2), and `SLACK`."""
    low, high = groups.min(axis=1), groups.max(axis=1)
    table = np.concatenate((0.5 * (low + high), 0.5 * (high - low) + SLACK), axis=1)
    return [(x, y, half_width, half_height) for x, y, half_width, half_height in table.tolist()]


def _met(boxes: list[_Box], x: float, y: float, ahead: float, aside: float) -> list[int]:
    """Return the numbers of the boxes that a segment from (x, y) by (ahead, aside) meets.

    By the separating axis theorem: along the axes of the boxes, and across the segment.
    """
    wide, high = abs(ahead), abs(aside)
    half_wide, half_high = 0.5 * wide, 0.5 * high
    middle_x, middle_y = x + 0.5 * ahead, y + 0.5 * aside
    return [
        number
        for number, (box_x, box_y, half_width, half_height) in enumerate(boxes)
        if abs(box_x - middle_x) <= half_width + half_wide
        and abs(box_y - middle_y) <= half_height + half_high
        and abs((box_y - middle_y) * ahead - (box_x - middle_x) * aside) <= half_height * wide + half_width * high
    ]
