"""How much of each pixel a disc covers: anti-aliasing without sampling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float32]

FLAT = 1e-3
"""Least share of an edge's normal along either axis; below it two squares of the closed form would cancel."""


def edge_coverage(distances: Pixels, spot_px: float = 1.0) -> Pixels:
    """Return how much of each pixel's spot lies where a distance field is negative.

    Exact for straight edges: the box of a pixel cut by a line has the area of a trapezoid's integral. At the edge of a
    circle of radius r pixels it is off by about 1/(24 r) of a pixel.

    Parameters
    ----------
    distances : (h, w) array
        Signed distance from the edge at the middle of each pixel, in any unit; at least 2 x 2.
    spot_px : float
        Side of the square from which a pixel takes its light [pixels]; 1 for a perfect lens.

    Returns
    -------
    (h, w) array
        In [0, 1].
    """
    down, across = np.gradient(distances)
    slope = np.sqrt(across * across + down * down) + np.float32(1e-12)
    offset = distances / (slope * np.float32(-spot_px))
    one, other = np.abs(across) / slope, np.abs(down) / slope
    wide, narrow = (np.maximum(share, np.float32(FLAT)) for share in (np.maximum(one, other), np.minimum(one, other)))
    outer, inner = (wide + narrow) / 2, (wide - narrow) / 2
    area = _ramp(offset + outer) - _ramp(offset + inner) - _ramp(offset - inner) + _ramp(offset - outer)
    covered: Pixels = np.clip(area / (2 * wide * narrow), 0, 1)
    # Far inside, differences of large squares lose digits, and at the middle of a disc the distance has no slope.
    return np.where(np.abs(offset) > 1, (distances < 0).astype(np.float32), covered)


def _ramp(offsets: Pixels) -> Pixels:
    positive = np.maximum(offsets, 0)
    squared: Pixels = positive * positive
    return squared
