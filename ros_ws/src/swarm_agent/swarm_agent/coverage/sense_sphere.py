"""Sense spheres: the points on the edge of a robot's coverage that stand for it (eqs. (2)-(4))."""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.config import CoverageConfig, Samples
from swarm_msgs_py.types import BoolArray, FloatArray

GRID_ANGLES = 20  # values of each rotation angle in the paper: pi/10, ..., 2 pi
SAME = 1e-9  # samples closer than this share of the radius are one
TOUCHING = 1e-6  # a sample this much beyond the range counts as covered: grid directions put many exactly on it


def grid_directions() -> FloatArray:
    """Return the paper's samples of the unit sphere, (182, 3).

    Of the 20 x 20 rotations (theta, psi) and (pi - theta, psi + pi) coincide, and all psi do at the poles, so that
    182 of 400 points are distinct.

    References
    ----------
    .. [1] 3D coverage paper, eqs. (2)-(4).
    """
    angles = 2.0 * np.pi * np.arange(1, GRID_ANGLES + 1) / GRID_ANGLES
    psi, theta = (grid.ravel() for grid in np.meshgrid(angles, angles))
    points = np.column_stack([np.cos(psi) * np.cos(theta), np.sin(psi) * np.cos(theta), -np.sin(theta)])
    cells = np.rint(points / SAME).astype(np.int64)
    _, first = np.unique(cells + 0, axis=0, return_index=True)
    distinct: FloatArray = points[np.sort(first)]
    return distinct


def fibonacci_directions(count: int) -> FloatArray:
    """Return `count` nearly uniform points of the unit sphere, (count, 3), from one pole to the other."""
    turn = np.pi * (1.0 + np.sqrt(5.0))  # golden ratio, in turns
    order = np.arange(count) + 0.5
    z = 1.0 - 2.0 * order / count
    ring = np.sqrt(1.0 - z * z)
    return np.column_stack([ring * np.cos(turn * order), ring * np.sin(turn * order), z])


def directions_of(config: CoverageConfig) -> FloatArray:
    """Return the samples of the unit sphere that the settings ask for, (q, 3)."""
    return grid_directions() if config.samples is Samples.GRID else fibonacci_directions(config.sample_count)


def covered_samples(directions: FloatArray, radius: float, offsets: FloatArray) -> BoolArray:
    """Return which samples of a sense sphere are within the coverage of which other robots.

    Parameters
    ----------
    directions : (q, 3) array
        Unit vectors.
    radius : float
        r_sc [m].
    offsets : (m, 3) array
        Where the others are, relative to the robot [m].

    Returns
    -------
    (q, m) bool array
    """
    # |r d - o| <= r (1 + t), squared and with |d| = 1: one product instead of q m distances.
    slack = radius * radius * TOUCHING * (2.0 + TOUCHING)
    bound = (np.einsum("ij,ij->i", offsets, offsets) - slack) / (2.0 * radius)
    covered: BoolArray = directions @ offsets.T >= bound
    return covered
