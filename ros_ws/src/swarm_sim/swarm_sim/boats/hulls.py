"""Which hulls overlap: the judge of collisions where the back end lets bodies pass through each other."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from swarm_msgs_py.types import FloatArray


def overlapping_hulls(poses: FloatArray, side_m: float, tolerance_m: float = 0.0) -> list[tuple[int, int]]:
    """Return the pairs of rows whose squares overlap by more than a tolerance, ascending.

    Parameters
    ----------
    poses : (n, 3) array
    side_m : float
        Edge of a hull [m].
    tolerance_m : float
        Overlap that is only contact [m].
    """
    half = 0.5 * side_m
    near = cKDTree(poses[:, :2]).query_pairs(np.sqrt(2.0) * side_m, output_type="ndarray").reshape(-1, 2)
    if not len(near):
        return []
    depth = np.full(len(near), np.inf)
    for one, other in ((0, 1), (1, 0)):  # separating axes: the two of each square
        base, guest = poses[near[:, one]], poses[near[:, other]]
        turn = guest[:, 2] - base[:, 2]
        cos, sin = np.cos(base[:, 2]), np.sin(base[:, 2])
        gap = guest[:, :2] - base[:, :2]
        local = np.column_stack([cos * gap[:, 0] + sin * gap[:, 1], -sin * gap[:, 0] + cos * gap[:, 1]])
        reach = half * (np.abs(np.cos(turn)) + np.abs(np.sin(turn)))
        depth = np.minimum(depth, (half + reach[:, None] - np.abs(local)).min(axis=1))
    return sorted((int(min(i, j)), int(max(i, j))) for i, j in near[depth > tolerance_m])
