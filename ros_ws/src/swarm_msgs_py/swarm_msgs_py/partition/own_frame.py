"""A shape's own frame of reference, so that what is computed in it turns and moves with the shape."""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.geometry.contour import area_centroid, boundary_center
from swarm_msgs_py.partition.rounding import on_grid
from swarm_msgs_py.types import FloatArray

ROUND = 1e-4  # shapes whose second moments differ by less than this share have no principal axis
EVEN = 1e-6  # [m]; boundary centers that are no farther to one side are in the middle, up to rounding
# Which way the axis of an even shape points. It turns around where this does not matter to any usual drawing.
_USUAL = np.array([1.0, 0.4])


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
        side = _along(boundary_center(contour) - self._origin, axis)
        if abs(side) < EVEN:
            side = _along(_USUAL, axis)
        self._axis = -axis if side < 0.0 else axis

    def enter(self, points: FloatArray) -> FloatArray:
        """Return (n, 2) points of the world in this frame, rounded to a micrometer.

        So a turned shape is the same shape, and where its center is up to the last bits does not matter any more.
        """
        (x, y), (cosine, sine) = (points - self._origin).T, self._axis
        return on_grid(np.column_stack([cosine * x + sine * y, cosine * y - sine * x]))

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
    size = math.sqrt(difference * difference + twice * twice)
    if size < ROUND * (xx + yy):
        return np.array([1.0, 0.0])
    # Half of the angle; the larger of sine and cosine first, since the other would lose half of its digits.
    larger = math.sqrt((1.0 + abs(difference) / size) / 2.0)
    smaller = twice / (2.0 * size * larger)
    return np.array([larger, smaller] if difference >= 0.0 else [smaller, larger])


def _along(vector: FloatArray, axis: FloatArray) -> float:
    return float(vector[0] * axis[0] + vector[1] * axis[1])
