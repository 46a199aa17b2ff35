"""Means of an image over squares that may lie anywhere on it, between its pixels as well.

A table of sums from the corner of the image (Crow 1984) gives the sum over a rectangle from its four corners. Between
the corners of pixels the sum is bilinear, because the image is constant within a pixel: so this is exact for squares of
any size and place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_sim.camera.exposure import LightArray

Table = NDArray[np.float64]


def square_means(image: LightArray, across: Table, down: Table, side: float) -> LightArray:
    """Return the means (h, w, c) of an image over squares.

    Parameters
    ----------
    image : (rows, columns, c) float32 array
        Pixel (row, column) covers [row, row + 1) x [column, column + 1).
    across, down : (h, w) array
        Middles of the squares [pixels], across columns and down rows from the upper left corner of the image. The
        squares must lie within it.
    side : float
        Of the squares [pixels].

    Returns
    -------
    (h, w, c) float32 array

    Raises
    ------
    ValueError
        If a square does not lie within the image.
    """
    half = side / 2.0
    rows, columns, channels = image.shape
    if min(across.min(), down.min()) < half or across.max() > columns - half or down.max() > rows - half:
        raise ValueError("a square does not lie within the image")
    sums = np.zeros((rows + 1, columns + 1, channels))
    np.cumsum(image, axis=0, dtype=np.float64, out=sums[1:, 1:])
    np.cumsum(sums[1:, 1:], axis=1, out=sums[1:, 1:])
    left, right = _places(across - half, columns), _places(across + half, columns)
    top, bottom = _places(down - half, rows), _places(down + half, rows)
    whole = (
        _between(sums, bottom, right)
        - _between(sums, top, right)
        - _between(sums, bottom, left)
        + _between(sums, top, left)
    )
    means: LightArray = (whole / side**2).astype(np.float32)
    return means


def _places(along: Table, count: int) -> tuple[NDArray[np.intp], Table]:
    """Return whole numbers of pixels below `count`, and what is left (..., 1) of distances from the corner [pixels]."""
    whole = np.clip(along.astype(np.intp), 0, count - 1)
    return whole, (along - whole)[..., None]


def _between(sums: Table, down: tuple[NDArray[np.intp], Table], across: tuple[NDArray[np.intp], Table]) -> Table:
    """Return the table's values (h, w, c) at places between its entries."""
    (row, below), (column, beyond) = down, across
    upper = sums[row, column] + beyond * (sums[row, column + 1] - sums[row, column])
    lower = sums[row + 1, column] + beyond * (sums[row + 1, column + 1] - sums[row + 1, column])
    values: Table = upper + below * (lower - upper)
    return values
