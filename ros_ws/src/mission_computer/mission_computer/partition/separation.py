"""Keeping circles apart and inside: the hard part of a packing, whatever the forces want."""

from __future__ import annotations

import numpy as np

from mission_computer.partition.domain import Domain
from swarm_msgs_py.types import FloatArray

SLACK = 1e-6  # [m]; far below every gap, far above rounding
ROUNDS_MAX = 50  # sweeps of pushing apart and back inside; a packing that is not too tight needs one to five


def is_separated(domain: Domain, centers: FloatArray) -> bool:
    """Return whether every two of the (n, 2) centers keep their least distance."""
    return bool((_overlaps(domain, centers)[2] <= SLACK).all())


def separate(domain: Domain, centers: FloatArray) -> FloatArray:
    """Return (n, 2) centers moved as little as needed: into their free regions, and overlapping pairs apart.

    Pairs may still overlap where the room is tight; `is_separated` tells.
    """
    centers = domain.project(centers)
    for _ in range(ROUNDS_MAX):
        first, second, depth = _overlaps(domain, centers)
        deep = depth > 0.1 * SLACK
        if not deep.any():
            break
        first, second, depth = first[deep], second[deep], depth[deep]
        offsets = centers[first] - centers[second]
        distances = np.linalg.norm(offsets, axis=1)
        # Two circles at one point part along x; which way does not matter, that it is always the same does.
        units = np.where(distances[:, None] > SLACK, offsets / np.maximum(distances, SLACK)[:, None], [1.0, 0.0])
        pushes = 0.5 * depth[:, None] * units
        np.add.at(centers, first, pushes)
        np.add.at(centers, second, -pushes)
        centers = domain.project(centers)
    return centers


def _overlaps(
    domain: Domain, centers: FloatArray
) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], np.ndarray[tuple[int], np.dtype[np.int64]], FloatArray]:
    """Return the pairs that are too near (both indices), and by how much each [m]."""
    x, y = centers.T
    dx, dy = x[:, None] - x, y[:, None] - y
    lack = domain.least_distances - np.sqrt(dx * dx + dy * dy)
    first, second = np.nonzero(np.triu(lack > 0.0, 1))
    return first, second, lack[first, second]
