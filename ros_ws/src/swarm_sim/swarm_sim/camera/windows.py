"""Which part of the image shows something round."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from swarm_msgs_py.types import FloatArray
from swarm_sim.camera.optics import Optics

Window = tuple[slice, slice]
"""Rows and columns of an image."""
EDGE_PX = 3
"""Pixels around a circle that its edge may reach, where the lens is not sharp."""
WIDER = 1.03
"""A polygon of 16 corners around a circle, relative to it."""
LEAST_PX = 2


def window_around(optics: Optics, center: FloatArray, radius: float, heights: Iterable[float]) -> Window | None:
    """Return the part of the image that may show horizontal discs above each other, None if all are out of view.

    Parameters
    ----------
    optics : Optics
    center : (2,) array
        [m].
    radius : float
        [m].
    heights : iterable of float
        Of the discs [m].
    """
    angles = np.arange(0.0, 2.0 * np.pi, np.pi / 8.0)
    ring = center + WIDER * radius * np.column_stack([np.cos(angles), np.sin(angles)])
    points = [np.column_stack([ring, np.full(len(ring), height)]) for height in heights]
    pixels = optics.project(np.concatenate(points))
    size = np.array([optics.info.width, optics.info.height])
    low = np.clip(np.floor(pixels.min(axis=0)).astype(int) - EDGE_PX, 0, size)
    high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + EDGE_PX + 1, 0, size)
    if (high - low).min() < LEAST_PX:  # an edge has no slope in a single row
        return None
    return slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))
