"""A shape's own frame of reference, so that what is computed in it turns and moves with the shape."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.geometry.contour import area_centroid, boundary_center
from swarm_msgs_py.types import FloatArray

ROUND = 1e-6  # shapes whose second moments differ by less than this share have no principal axis


class OwnFrame:
    """Origin at the center of area, x along the principal axis, toward the side of the boundary center.

    Parameters
    ----------
    contour : (k, 2) array
        Simple and counter-clockwise [m].
    """

    def __init__(self, contour: FloatArray) -> None:
        self._origin = area_centroid(contour)
        axis = _principal_axis(contour - self._origin)
        toward = boundary_center(contour) - self._origin
        self._axis = -axis if float(toward[0] * axis[0] + toward[1] * axis[1]) < 0.0 else axis

    def enter(self, points: FloatArray) -> FloatArray:
        """Return (n, 2) points of the world in this frame."""
        (x, y), (cosine, sine) = (points - self._origin).T, self._axis
        return np.column_stack([cosine * x + sine * y, cosine * y - sine * x])

    def leave(self, points: FloatArray) -> FloatArray:
        """Return (n, 2) points of this frame in the world."""
        (x, y), (cosine, sine) = points.T, self._axis
        return np.column_stack([cosine * x - sine * y, sine * x + cosine * y]) + self._origin


def _principal_axis(contour: FloatArray) -> FloatArray:
    """Return the unit vector along which the area of a contour about the origin is spread widest."""
    (x, y), (u, v) = contour.T, np.roll(contour, -1, axis=0).T
    cross = x * v - u * y
    xx = float((cross * (x * x + x * u + u * u)).sum()) / 12.0
    yy = float((cross * (y * y + y * v + v * v)).sum()) / 12.0
    xy = float((cross * (x * v + 2.0 * (x * y + u * v) + u * y)).sum()) / 24.0
    difference, twice = xx - yy, 2.0 * xy
    size = (difference * difference + twice * twice) ** 0.5
    if size < ROUND * (xx + yy):
        return np.array([1.0, 0.0])
    cosine = ((1.0 + difference / size) / 2.0) ** 0.5
    sine = ((1.0 - difference / size) / 2.0) ** 0.5
    return np.array([cosine, sine if twice >= 0.0 else -sine])
