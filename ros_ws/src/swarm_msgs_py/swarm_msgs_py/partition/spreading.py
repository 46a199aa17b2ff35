"""Which circle gets which center, so that circles of every size are all over the shape."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.types import FloatArray, IntArray

CURVE_CELLS = 64  # cells of the curve along each axis: finer than the robots stand


def spread_sizes(domain: Domain, centers: FloatArray) -> FloatArray:
    """Return the (n, 2) centers in another order, in which the sizes of the circles take turns along Hilbert's curve.

    The curve goes through one corner of the shape after the other, so what takes turns along it is spread evenly.
    """
    share, kind = np.empty(len(centers)), np.empty(len(centers))
    for index, radius in enumerate(domain.classes):
        rows = np.flatnonzero(domain.radii == radius)
        share[rows], kind[rows] = (np.arange(len(rows)) + 0.5) / len(rows), index
    spread = np.empty_like(centers)
    spread[np.lexsort((kind, share))] = centers[np.argsort(_along_curve(centers), kind="stable")]
    return spread


def _along_curve(points: FloatArray) -> IntArray:
    """Return the place of each of (n, 2) points on Hilbert's curve through a square around them, (n,).

    References
    ----------
    .. [1] D. Hilbert, "Ueber die stetige Abbildung einer Linie auf ein Flaechenstueck", Mathematische Annalen 38, 1891.
    """
    low = points.min(axis=0)
    size = max(float((points.max(axis=0) - low).max()), 1.0)
    x, y = np.minimum((points - low) * (CURVE_CELLS / size), CURVE_CELLS - 1).astype(np.int64).T
    place = np.zeros(len(points), dtype=np.int64)
    side = CURVE_CELLS // 2
    while side:
        right, upper = (x & side) > 0, (y & side) > 0
        place += side * side * np.where(right, np.where(upper, 2, 3), np.where(upper, 1, 0))
        # The curve in the lower quarters is turned, in the right one of them to the other side.
        flipped = right & ~upper
        x, y = np.where(flipped, CURVE_CELLS - 1 - x, x), np.where(flipped, CURVE_CELLS - 1 - y, y)
        x, y = np.where(upper, x, y), np.where(upper, y, x)
        side //= 2
    return place
