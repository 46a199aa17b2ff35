"""Measures of closed polygonal contours.

Products are summed without BLAS, whose last bits differ between processors: everything that robots compute alone begins
with these centers.
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import FloatArray


def signed_area(contour: FloatArray) -> float:
    """Return the area enclosed by a (k, 2) contour [m^2], positive if counter-clockwise (thesis eq. (3.72))."""
    # Coordinates far from the origin would cancel; the area does not depend on where the origin is.
    x, y = (contour - contour[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def boundary_center(contour: FloatArray) -> FloatArray:
    """Return the length-weighted mean z_c of a closed (k, 2) contour, a (2,) array (thesis eqs. (3.65)-(3.66)).

    It may lie outside a contour that is not convex.
    """
    following = np.roll(contour, -1, axis=0)
    lengths = np.linalg.norm(following - contour, axis=1)
    center: FloatArray = (lengths[:, None] * (0.5 * (contour + following))).sum(axis=0) / lengths.sum()
    return center


def area_centroid(contour: FloatArray) -> FloatArray:
    """Return the center of area of a simple closed (k, 2) contour, a (2,) array."""
    origin = contour[0]
    here = contour - origin
    following = np.roll(here, -1, axis=0)
    cross = here[:, 0] * following[:, 1] - following[:, 0] * here[:, 1]
    centroid: FloatArray = origin + (cross[:, None] * (here + following)).sum(axis=0) / (3.0 * cross.sum())
    return centroid
