"""Ball, box and prism."""

from __future__ import annotations

import numpy as np
import shapely

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import BoolArray, FloatArray


class Ball:
    """A ball.

    Parameters
    ----------
    center : (3,) array
        [m].
    radius : float
        [m].
    """

    def __init__(self, center: FloatArray, radius: float) -> None:
        self._center = np.asarray(center, dtype=np.float64)
        self._radius = float(radius)

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        return np.stack([self._center - self._radius, self._center + self._radius])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        offsets = points - self._center
        inside: BoolArray = np.einsum("ij,ij->i", offsets, offsets) <= self._radius**2
        return inside


class Box:
    """A box with edges along the axes of the world.

    Parameters
    ----------
    center, size : (3,) array
        Center, and length of the edges [m].
    """

    def __init__(self, center: FloatArray, size: FloatArray) -> None:
        self._center = np.asarray(center, dtype=np.float64)
        self._half = 0.5 * np.asarray(size, dtype=np.float64)

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        return np.stack([self._center - self._half, self._center + self._half])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        is_within = np.abs(points - self._center) <= self._half
        inside: BoolArray = is_within[:, 0] & is_within[:, 1] & is_within[:, 2]  # quicker than all() of short rows
        return inside


class Prism:
    """A polygon on the ground, extruded upward.

    Parameters
    ----------
    corners : (k, 2) array
        Simple polygon, in either direction [m].
    bottom, top : float
        Heights between which it stands [m].

    Raises
    ------
    ShapeError
        If the polygon crosses itself or has no area, or the prism no height.
    """

    def __init__(self, corners: FloatArray, bottom: float, top: float) -> None:
        if len(corners) < 3:
            raise ShapeError(f"a polygon needs 3 corners, got {len(corners)}")
        self._polygon = shapely.Polygon(corners)
        if not self._polygon.is_valid or self._polygon.area <= 0.0:
            raise ShapeError(f"the polygon is not simple: {shapely.is_valid_reason(self._polygon)}")
        if not top > bottom:
            raise ShapeError(f"the top of a prism ({top:g} m) must be above its bottom ({bottom:g} m)")
        self._bottom, self._top = float(bottom), float(top)
        shapely.prepare(self._polygon)

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        left, front, right, back = self._polygon.bounds
        return np.array([[left, front, self._bottom], [right, back, self._top]])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        inside: BoolArray = np.asarray((points[:, 2] >= self._bottom) & (points[:, 2] <= self._top))
        inside[inside] = np.asarray(shapely.intersects_xy(self._polygon, *points[inside, :2].T))
        return inside
