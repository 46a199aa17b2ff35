"""Geometry of the polygonal obstacles, vectorized: distance, nearest surface, line of sight, convex pieces."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, constrained_delaunay_triangles, union
from shapely.geometry.polygon import orient

from swarm_msgs_py.types import FloatArray, IntArray

BoolArray = NDArray[np.bool_]

CONVEX_SLACK = 1e-9
"""Share of its hull's area that a polygon may lack and still count as convex: rounding only."""


class ObstacleField:
    """All obstacles of a scene as one table of edges.

    Parameters
    ----------
    polygons : sequence of (k, 2) array
        Simple polygons, either orientation [m].
    """

    def __init__(self, polygons: Sequence[FloatArray]) -> None:
        rings = [np.array(orient(Polygon(corners)).exterior.coords)[:-1] for corners in polygons]
        self.count = len(rings)
        self.corners: tuple[FloatArray, ...] = tuple(rings)
        sizes = np.array([len(ring) for ring in rings], dtype=np.int64)
        self._first = np.cumsum(sizes) - sizes
        self.starts: FloatArray = np.concatenate([np.empty((0, 2)), *rings])
        ends = np.concatenate([np.empty((0, 2)), *(np.roll(ring, -1, axis=0) for ring in rings)])
        self._along = ends - self.starts
        self._length2 = (self._along**2).sum(axis=1)
        self._before = np.arange(len(self.starts)) - 1  # each edge's predecessor around its obstacle
        self._before[self._first] += sizes
        self._low = np.array([ring.min(axis=0) for ring in rings]).reshape(-1, 2)
        self._high = np.array([ring.max(axis=0) for ring in rings]).reshape(-1, 2)

    def box_distances(self, points: FloatArray) -> FloatArray:
        """Return the distance (n, obstacles) from points (n, 2) to the obstacles' bounding boxes [m]."""
        outside = (
            np.maximum(np.maximum(low - place[:, None], place[:, None] - high), 0.0)
            for low, place, high in zip(self._low.T, points.T, self._high.T, strict=True)
        )
        gap: FloatArray = np.hypot(*outside)
        return gap

    def signed_distances(self, points: FloatArray, obstacle: int) -> FloatArray:
        """Return the distance (n,) from points (n, 2) to one obstacle, negative inside [m]."""
        starts, along, length2 = self._edges_of(obstacle)
        offset = points[:, None] - starts
        share = np.minimum(np.maximum(_dot(offset, along) / length2, 0.0), 1.0)
        away = offset - share[..., None] * along
        distance = np.sqrt(_dot(away, away).min(axis=1))
        # Crossing number of the ray towards +x.
        below = offset[..., 1] >= 0.0
        crosses = below != (offset[..., 1] >= along[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            crosses &= offset[..., 0] < offset[..., 1] / along[:, 1] * along[:, 0]
        signed: FloatArray = np.where(crosses.sum(axis=1) % 2 == 1, -distance, distance)
        return signed

    def facing_points(self, points: FloatArray, reach: float) -> tuple[IntArray, FloatArray]:
        """Return the nearest points of all wall faces within reach, seen from outside.

        A face gives a point where the distance along the boundary has a local minimum on the side turned to the
        observer. So a straight wall or an outer corner gives one point and an inner corner gives one per wall.

        Parameters
        ----------
        points : (n, 2) array
            Observers [m].
        reach : float
            Farthest point that counts [m].

        Returns
        -------
        observers : (k,) int array
            Row of the observer, ascending.
        surface : (k, 2) array
            Nearest point of the face, world frame [m].
        """
        offset = points[:, None] - self.starts
        along, away = self._along, np.empty_like(offset)
        raw = _dot(offset, along) / self._length2
        share = np.minimum(np.maximum(raw, 0.0), 1.0)
        for axis in range(2):
            away[..., axis] = offset[..., axis] - share * along[:, axis]
        # Counter-clockwise corners: the outside is to the right of an edge.
        is_facing = along[:, 0] * offset[..., 1] - along[:, 1] * offset[..., 0] < 0.0
        is_before, before = raw < 0.0, self._before
        on_face = ~is_before & (raw < 1.0) & is_facing
        # A corner is nearest where the edge before it ends short of the foot and the next begins beyond it.
        on_corner = is_before & (raw >= 1.0)[:, before] & (is_facing | is_facing[:, before])
        observers, edges = np.nonzero((on_face | on_corner) & (_dot(away, away) <= reach**2))
        return observers, self.starts[edges] + share[observers, edges, None] * along[edges]

    def is_blocked(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        """Return whether each segment (n, 2) to (n, 2) touches an obstacle's boundary.

        Both ends are taken to be outside; so a segment that touches no boundary is free.
        """
        blocked: BoolArray = np.zeros(len(starts), dtype=np.bool_)
        if not (len(starts) and self.count):
            return blocked
        low, high = np.minimum(starts, ends), np.maximum(starts, ends)
        (west, south), (east, north) = low.T.copy(), high.T.copy()
        is_near = ((self._low <= high.max(axis=0)) & (self._high >= low.min(axis=0))).all(axis=1)
        for obstacle in np.flatnonzero(is_near).tolist():
            (x_min, y_min), (x_max, y_max) = self._low[obstacle].tolist(), self._high[obstacle].tolist()
            rows = np.flatnonzero((west <= x_max) & (east >= x_min) & (south <= y_max) & (north >= y_min))
            if rows.size:
                edges, along, _ = self._edges_of(obstacle)
                blocked[rows] |= _any_crossing(starts[rows], ends[rows], edges, along)
        return blocked

    def _edges_of(self, obstacle: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        first = self._first[obstacle]
        part = slice(first, first + len(self.corners[obstacle]))
        return self.starts[part], self._along[part], self._length2[part]


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the inner products of vectors (..., 2); a sum over an axis of two takes several times as long."""
    product: FloatArray = first[..., 0] * second[..., 0] + first[..., 1] * second[..., 1]
    return product


def _any_crossing(starts: FloatArray, ends: FloatArray, edges: FloatArray, along: FloatArray) -> BoolArray:
    """Return for each segment whether it meets any of the edges."""
    ray = (ends - starts)[:, None]
    offset = edges - starts[:, None]
    # Sides of the edge's two ends relative to the segment, and of the segment's two ends relative to the edge.
    side = ray[..., 0] * offset[..., 1] - ray[..., 1] * offset[..., 0]
    turn = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    place = along[:, 0] * offset[..., 1] - along[:, 1] * offset[..., 0]
    meets: BoolArray = (side * (side + turn) <= 0.0) & (place * (place + turn) <= 0.0)
    if not meets.any():
        return np.zeros(len(starts), dtype=np.bool_)
    # On one line all four sides are zero; then only overlapping boxes make a contact.
    low, high = np.minimum(edges, edges + along), np.maximum(edges, edges + along)
    meets &= (np.minimum(starts, ends)[:, None] <= high).all(axis=-1)
    meets &= (np.maximum(starts, ends)[:, None] >= low).all(axis=-1)
    return np.asarray(meets.any(axis=1))


def convex_pieces(polygon: FloatArray) -> tuple[FloatArray, ...]:
    """Return convex polygons (k, 2), counter-clockwise, whose union is the polygon.

    Triangles of the constrained Delaunay triangulation are merged greedily while the union stays convex; the order of
    the pieces depends on nothing but the corners.
    """
    pieces = sorted(constrained_delaunay_triangles(Polygon(polygon)).geoms, key=lambda piece: piece.centroid.coords[0])
    pair = _convex_pair(pieces)
    while pair is not None:
        i, j, joined = pair
        pieces[i] = joined
        del pieces[j]
        pair = _convex_pair(pieces)
    return tuple(np.array(orient(piece).exterior.coords)[:-1] for piece in pieces)


def _convex_pair(pieces: list[Polygon]) -> tuple[int, int, Polygon] | None:
    """Return the first two pieces, i < j, whose union is convex, and that union."""
    for i, j in combinations(range(len(pieces)), 2):
        joined = union(pieces[i], pieces[j])
        hull = joined.convex_hull
        if joined.geom_type == "Polygon" and hull.area - joined.area <= CONVEX_SLACK * hull.area:
            return i, j, hull
    return None
