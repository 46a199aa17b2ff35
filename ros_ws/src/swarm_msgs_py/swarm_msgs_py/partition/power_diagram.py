"""Power diagrams: which part of the plane belongs to which of several weighted sites."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull

from swarm_msgs_py.types import FloatArray, IntArray

FLAT = 1e-12  # triangles with less area than this share of the mean are rounding, and their power center is nowhere
# Auxiliary sites around all others, so that every cell has an end: directions of a triangle.
_AROUND = np.array([[1.0, 0.0], [-0.5, math.sqrt(0.75)], [-0.5, -math.sqrt(0.75)]])


class PowerDiagram:
    """Cells of the points x for which abs(x - site_i)^2 - weight_i is least; equal weights give a Voronoi diagram.

    Sites lifted to a paraboloid have the diagram's dual as the lower part of their convex hull; Qhull decides which
    sites are neighbors, and everything that is measured is computed here from the sites.

    Parameters
    ----------
    sites : (n, 2) array
        Not far from the origin, where squares would cancel [m].
    weights : (n,) array
        [m^2].
    far : float
        Distance of the auxiliary sites from the origin, several times that of every point that is asked for [m].

    Attributes
    ----------
    count : int
        Number of sites n; larger site numbers are auxiliary.
    sites : (n + 3, 2) array
        The sites, then the auxiliary ones [m].
    lifted : (n + 3,) array
        Square of the distance from the origin less the weight [m^2].
    pairs : (m, 2) int array
        Neighbors, each pair once. On the way from `starts` to `ends`, the first has its cell on the left.
    starts, ends : (m, 2) array
        The edge between the two cells [m].
    triangles : (t, 3) int array
        Triangles of the dual whose corners are no auxiliary sites.
    centers : (t, 2) array
        The point where the cells of a triangle's corners meet [m].
    """

    def __init__(self, sites: FloatArray, weights: FloatArray, far: float) -> None:
        self.count = len(sites)
        self.sites = np.concatenate([sites, far * _AROUND])
        self.lifted = self.sites[:, 0] ** 2 + self.sites[:, 1] ** 2
        self.lifted[: self.count] -= weights
        hull = ConvexHull(np.column_stack([self.sites, self.lifted]))
        is_lower = hull.equations[:, 2] < 0.0
        centers, cross = self._power_centers(hull.simplices)
        facet, opposite = np.nonzero(is_lower[:, None] & is_lower[hull.neighbors])
        beside = hull.neighbors[facet, opposite]
        once = facet < beside
        facet, opposite, beside = facet[once], opposite[once], beside[once]
        one = hull.simplices[facet, (opposite + 1) % 3]
        other = hull.simplices[facet, (opposite + 2) % 3]
        # With the third corner to the left of the way from `one` to `other`, the edge runs off to the right.
        turns_left = (cross[facet] > 0.0)[:, None]
        self.pairs: IntArray = np.where(
            turns_left, np.column_stack([other, one]), np.column_stack([one, other])
        ).astype(np.int64)
        self.starts, self.ends = centers[facet], centers[beside]
        is_own = is_lower & (hull.simplices < self.count).all(axis=1)
        self.triangles: IntArray = hull.simplices[is_own].astype(np.int64)
        self.centers = centers[is_own]

    def _power_centers(self, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return where the cells of three sites meet, and twice the signed area of the triangle between the sites."""
        corners, heights = self.sites[triangles], self.lifted[triangles]
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        rise_1, rise_2 = heights[:, 1] - heights[:, 0], heights[:, 2] - heights[:, 0]
        cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        least = FLAT * float(np.abs(cross).mean())
        double = 2.0 * np.where(np.abs(cross) > least, cross, np.inf)
        x = (second[:, 1] * rise_1 - first[:, 1] * rise_2) / double
        y = (first[:, 0] * rise_2 - second[:, 0] * rise_1) / double
        return np.column_stack([x, y]), cross
