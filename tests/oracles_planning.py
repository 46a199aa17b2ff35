"""Slow and obvious references for the path planner: every corner is a node, every pair is tested by Shapely."""

from __future__ import annotations

import math

import numpy as np
import shapely
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import shortest_path
from shapely.geometry import LineString, MultiPoint, Point, Polygon

from swarm_msgs_py.types import FloatArray

TOUCH = 1e-6  # a path may run this deep [m] inside the forbidden space and still count as sliding along it


def grown_by_triangles(obstacles: tuple[FloatArray, ...], disc: FloatArray) -> shapely.Geometry:
    """Minkowski sum by its definition: cut each obstacle into triangles, sum all pairs of corners, take the hulls."""
    pieces = []
    for obstacle in obstacles:
        for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(Polygon(obstacle))):
            corners = np.asarray(triangle.exterior.coords)[:-1]
            pieces.append(MultiPoint([corner + offset for corner in corners for offset in disc]).convex_hull)
    return shapely.union_all(pieces) if pieces else Polygon()


def regular_polygon_around(radius: float, sides: int) -> FloatArray:
    """Regular polygon whose sides touch the circle, two of them upright."""
    angles = [2.0 * math.pi * (side + 0.5) / sides for side in range(sides)]
    reach = radius / math.cos(math.pi / sides)
    return np.array([(reach * math.cos(angle), reach * math.sin(angle)) for angle in angles])


def brute_force_cost(forbidden: shapely.Geometry, start: FloatArray, goal: FloatArray) -> float:
    """Length of the shortest path over the complete visibility graph; inf where there is none."""
    solid = forbidden.buffer(-TOUCH, join_style="mitre")
    if solid.intersects(Point(goal)) or solid.intersects(Point(start)):
        return math.inf
    points = np.vstack((start, goal, shapely.get_coordinates(forbidden)))
    one, two = np.triu_indices(len(points), k=1)
    shapely.prepare(solid)
    clear = ~shapely.intersects(solid, shapely.linestrings(np.stack((points[one], points[two]), axis=1)))
    # A sparse matrix, because a dense one takes a length of zero (start = goal) for "no edge".
    lengths = np.linalg.norm(points[one] - points[two], axis=1)[clear]
    graph = csr_array((lengths, (one[clear], two[clear])), shape=(len(points), len(points)))
    return float(shortest_path(graph, method="D", directed=False, indices=0)[1])


def polyline_length(points: FloatArray) -> float:
    return float(LineString(points).length)


@st.composite
def star_polygon(draw: st.DrawFn) -> FloatArray:
    """Simple polygon, convex or not, in either direction: random distances at ordered angles around a center."""
    count = draw(st.integers(3, 7))
    center = np.array([draw(st.floats(-7.0, 7.0)), draw(st.floats(-7.0, 7.0))])
    distances = np.array([draw(st.floats(0.4, 3.0)) for _ in range(count)])
    shares = np.array([draw(st.floats(0.5, 1.5)) for _ in range(count)])
    angles = draw(st.floats(0.0, math.tau)) + math.tau * np.cumsum(shares) / shares.sum()
    polygon = center + distances[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    return polygon if draw(st.booleans()) else polygon[::-1]


def scenes(most: int = 5) -> st.SearchStrategy[tuple[FloatArray, ...]]:
    """A few polygons, apart from each other or overlapping."""
    return st.lists(star_polygon(), max_size=most).map(tuple)


def points() -> st.SearchStrategy[FloatArray]:
    return st.tuples(st.floats(-11.0, 11.0), st.floats(-11.0, 11.0)).map(np.array)
