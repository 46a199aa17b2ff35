"""The repulsion of a contour, integrated in closed form over its edges."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import FloatArray

HEIGHT_MIN = 1e-3  # [m]; the integral grows like 2/h toward an edge and must stay finite on it


class ShapeForce:
    """Contour integral of (z - zeta) / abs(z - zeta)^3 ds for a fixed polygon (thesis eqs. (3.83), (3.96)).

    The exact integral per edge replaces the thesis' sum over points 0.01 m apart; it is right at any distance.

    Parameters
    ----------
    contour : (k, 2) array
        Polygon, counter-clockwise [m].
    """

    def __init__(self, contour: FloatArray) -> None:
        edges = np.roll(contour, -1, axis=0) - contour
        self._lengths = np.linalg.norm(edges, axis=1)
        self._tangents = edges / self._lengths[:, None]
        self._normals = np.column_stack([-self._tangents[:, 1], self._tangents[:, 0]])
        self._starts = (contour * self._tangents).sum(axis=1)
        self._heights = (contour * self._normals).sum(axis=1)
        self._before = np.roll(self._tangents, 1, axis=0) - self._tangents

    def at(self, points: FloatArray) -> FloatArray:
        """Return the force at (n, 2) points [1/m], an (n, 2) array that points away from the contour."""
        first = self._starts - points @ self._tangents.T
        heights = self._heights - points @ self._normals.T
        last = first + self._lengths
        nearness = 1.0 / np.maximum(np.sqrt(heights * heights + first * first), HEIGHT_MIN)  # 1 / rho_1 of each edge
        following = np.concatenate([nearness[:, 1:], nearness[:, :1]], axis=1)  # an edge ends where the next begins
        floored = np.copysign(np.maximum(np.abs(heights), HEIGHT_MIN), heights)
        across = (first * nearness - last * following) / floored
        # Sum over edges of t (1/rho_2 - 1/rho_1), collected per vertex: it ends one edge and begins the next.
        force: FloatArray = across @ self._normals + nearness @ self._before
        return force
