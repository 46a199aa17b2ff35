"""Where the center of a robot may be: obstacles grown by the robot's coverage circle (thesis section 3.4.1).

The circle is replaced by a regular polygon around it, so that the grown obstacles are polygons and shortest paths are
polylines over their corners. The polygon may also lie *inside* the circle: then the free space is larger than that of
any real robot, and path lengths are lower bounds.
"""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely.geometry import MultiPoint, Polygon
from shapely.geometry.polygon import orient

from swarm_agent.planning.line_of_sight import Walls
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray

GRID = 1e-8  # vertices of merged obstacles snap to this grid [m]: keeps unions free of slivers
STRAIGHT = 1e-7  # vertices that stick out less than this [m] are not corners
GRAZE = 1e-6  # paths may cut this deep [m] into grown obstacles, so that sliding along an edge is no collision
CONVEX = 1e-12  # relative area by which a polygon may fall short of its hull and still count as convex
MITRE_LIMIT = 4.0  # spikes of the shrunken space are cut at this multiple of GRAZE


def disc_polygon(radius: float, sides: int, *, inscribed: bool = False) -> FloatArray:
    """Return a regular polygon around (or inside) the circle about the origin.

    Parameters
    ----------
    radius : float
        Of the circle [m], >= 0.
    sides : int
    inscribed : bool
        Corners on the circle; otherwise the sides touch it.

    Returns
    -------
    (sides, 2) array
        Corners, counter-clockwise [m]. Walls along the axes grow by exactly `radius` if 4 divides `sides`.
    """
    step = 2.0 * math.pi / sides
    first, reach = (0.0, radius) if inscribed else (step / 2.0, radius / math.cos(step / 2.0))
    angles = first + step * np.arange(sides)
    return reach * np.column_stack((np.cos(angles), np.sin(angles)))


class ConfigurationSpace:
    """Forbidden and free positions of a robot's center.

    Parameters
    ----------
    obstacles : tuple of (k, 2) array
        Polygons, convex or not, in either direction [m]; they may overlap. Two points make a wall, one a post.
    disc : (s, 2) array
        Convex polygon that stands for the robot, the origin inside it [m].

    Attributes
    ----------
    forbidden : shapely geometry
        Union of the grown obstacles.
    rings : tuple of (k, 2) array
        Its outlines, the forbidden side on the left: counter-clockwise outside, clockwise around holes.
    walls : Walls
        What blocks a straight motion.

    Raises
    ------
    ShapeError
        If an obstacle is not a list of finite points.
    """

    def __init__(self, obstacles: tuple[FloatArray, ...], disc: FloatArray) -> None:
        grown = [_grow(_checked(obstacle, number), disc) for number, obstacle in enumerate(obstacles)]
        merged = shapely.union_all(grown, grid_size=GRID) if grown else Polygon()
        self.forbidden = shapely.simplify(merged, STRAIGHT).normalize()
        self.rings = _rings(self.forbidden)
        # A line that grazes the forbidden space keeps a distance of GRAZE to the shrunken one. So the test "meets the
        # interior" becomes "crosses a wall", with no special cases for shared vertices and collinear edges.
        shrunken = self.forbidden.buffer(-GRAZE, join_style="mitre", mitre_limit=MITRE_LIMIT)
        self.walls = Walls(_rings(shrunken))
        self._tails = np.concatenate([*self.rings, np.empty((0, 2))])
        self._edges = np.concatenate([*(np.roll(ring, -1, axis=0) - ring for ring in self.rings), np.empty((0, 2))])

    def is_free(self, point: FloatArray) -> bool:
        """Return whether a robot may be at `point` (the boundary, and `GRAZE` beyond it, is free)."""
        return not self.walls.enclose(float(point[0]), float(point[1]))

    def project(self, point: FloatArray) -> FloatArray:
        """Return `point` if it is free, else the nearest boundary point of the forbidden space, (2,) [m]."""
        if not self.walls.enclose(float(point[0]), float(point[1])):
            return point
        away = point - self._tails
        along = (away * self._edges).sum(axis=1) / (self._edges**2).sum(axis=1)
        feet = self._tails + np.clip(along, 0.0, 1.0)[:, None] * self._edges
        nearest: FloatArray = feet[np.argmin(((point - feet) ** 2).sum(axis=1))]
        return nearest


def _checked(obstacle: FloatArray, number: int) -> FloatArray:
    points = np.asarray(obstacle, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) == 0 or not np.isfinite(points).all():
        raise ShapeError(f"obstacle {number} is not a list of finite points (x, y)")
    return points


def _grow(obstacle: FloatArray, disc: FloatArray) -> shapely.Geometry:
    """Return the Minkowski sum of an obstacle and a convex polygon (thesis eq. (3.103))."""
    outline = Polygon(obstacle) if len(obstacle) > 2 else Polygon()
    hull = MultiPoint(obstacle).convex_hull
    if outline.is_valid and hull.area > 0.0 and outline.area > (1.0 - CONVEX) * hull.area:
        return _hull_of_sums(obstacle, disc)
    # Because the origin lies in the disc, A + disc is A itself and what the disc sweeps along the outline of A. The
    # sweep of one edge is convex; so no convex decomposition of A is needed.
    edges = np.stack((obstacle, np.roll(obstacle, -1, axis=0)), axis=1)
    sweeps = [_hull_of_sums(edge, disc) for edge in edges]
    return shapely.union_all([shapely.make_valid(outline).buffer(0.0), *sweeps], grid_size=GRID)


def _hull_of_sums(points: FloatArray, disc: FloatArray) -> shapely.Geometry:
    return MultiPoint((points[:, None, :] + disc[None, :, :]).reshape(-1, 2)).convex_hull


def _rings(geometry: shapely.Geometry) -> tuple[FloatArray, ...]:
    """Return the outlines of all polygons of a geometry, not closed, the inside on the left."""
    polygons = [orient(part) for part in shapely.get_parts(geometry) if isinstance(part, Polygon) and part.area > 0.0]
    return tuple(
        np.asarray(ring.coords, dtype=np.float64)[:-1, :2]
        for polygon in polygons
        for ring in (polygon.exterior, *polygon.interiors)
    )
