"""How hard obstacles push: the integral of thesis eq. (3.92) in closed form per edge.

With z the center of a robot of coverage radius r, zeta the running point of an outline and rho their distance:

    integral of (z - zeta) / gap^4 ds,   gap = max(rho - r, gap_min)

Seen from z, an edge runs from s1 to s2 along its tangent t, at height h along its normal e, so that
zeta - z = s t + h e. Where the gap is not clamped, the part along t needs the integral of s / (rho - r)^4, which is
elementary in rho, and the part along e that of 1 / (rho - r)^4. With the angle phi from the normal, s = h tan(phi), the
latter is h times the integral of cos(phi)^2 / (h - r cos(phi))^4, which derivatives of the integral of
1 / (h - r cos(phi)) give. In terms of T = h^2 - r^2, w = r^2 / T and the inverse gap v = 1 / (rho - r):

    E(s) = s v / (6 T) [r (13 + 15 w) / T + (3 + 5 w) v + 2 r v^2]  +  (1 + w) (1 + 5 w) / (2 T) K(s)

    K(s) = 2/c arctan(g),              g = (h + r) s / (c (rho + h)),   c = sqrt(T),   where h > r
    K(s) = 1/c ln((g - 1) / (g + 1)),  g as above,                      c = sqrt(-T),  where h < r

Where it is clamped, |s| < s0 = sqrt((r + gap_min)^2 - h^2), both parts are elementary.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from swarm_msgs_py.geometry.edges import Edges
from swarm_msgs_py.types import FloatArray

TANGENCY_MIN = 1e-4
"""Least |h^2 - r^2| [m^2]. The line of an edge that touches the coverage circle, off the end of the edge, makes E(s) a
difference of large numbers. Moving that line by at most 1e-4 / (2 r) keeps it exact to 1 % at the smallest gap."""

_TINY = 1e-300
"""Where an edge's line runs through the robot's center, g is 1 and K infinite, but its factor is 0."""


class ObstacleIntegral:
    """The integral over the outlines of fixed obstacles.

    Parameters
    ----------
    obstacles : sequence of (k, 2) array
        Outlines [m].
    gap_min : float
        Nearer points count as being this far away [m], > 0.
    """

    def __init__(self, obstacles: Sequence[FloatArray], gap_min: float) -> None:
        self._edges = Edges(obstacles)
        self._spans: FloatArray = np.stack([np.zeros_like(self._edges.lengths), self._edges.lengths])[:, None]
        self._gap_min = gap_min

    def at(self, points: FloatArray, radii: FloatArray) -> FloatArray:
        """Return the push on robots, away from the obstacles.

        Parameters
        ----------
        points : (n, 2) array
            Their centers [m].
        radii : (n,) array
            Their coverage radii [m], > 0.

        Returns
        -------
        (n, 2) array
            [1/m^2].
        """
        edges, r = self._edges, radii[:, None]
        first, heights = edges.seen_from(points)
        along, across = self._integrate(first + self._spans, _Lines(heights, radii), r)
        push: FloatArray = -(along @ edges.tangents) - (across * heights) @ edges.normals
        return push

    def _integrate(self, ends: FloatArray, lines: _Lines, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the integrals of s / gap^4 and of 1 / gap^4 from s1 to s2, the rows of `ends`; (n, e) each."""
        limit = r + self._gap_min
        passing = lines.squares < limit * limit
        if np.count_nonzero(passing):
            reach = np.sqrt(np.maximum(limit * limit - lines.squares, 0.0))  # s0: the gap is clamped for |s| below it
            # Ends on one side of the clamped stretch have it in common, and it cancels.
            if np.count_nonzero(passing & (ends[0] < reach) & (ends[1] > -reach)):
                return self._integrate_clamped(ends, reach, lines, r)
        along, across = lines.primitives(ends, np.sqrt(lines.squares + ends * ends))
        return along[1] - along[0], across[1] - across[0]

    def _integrate_clamped(
        self, ends: FloatArray, reach: FloatArray, lines: _Lines, r: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return what `_integrate` does, where the gap is clamped for |s| below `reach`, (n, e) [m]."""
        limit = r + self._gap_min
        rho = np.maximum(np.sqrt(lines.squares + ends * ends), limit)
        along, across = lines.primitives(np.copysign(np.maximum(np.abs(ends), reach), ends), rho)
        _, at_reach = lines.primitives(reach, np.maximum(lines.h, limit))
        across -= np.where(ends < 0.0, -at_reach, at_reach)
        inner = np.clip(ends, -reach, reach) / self._gap_min**2
        along += 0.5 * inner * inner
        across += inner / self._gap_min**2
        return along[1] - along[0], across[1] - across[0]


class _Lines:
    """What E(s) needs of the lines of all edges, (n, e), for robots of (n,) coverage radii."""

    def __init__(self, heights: FloatArray, radii: FloatArray) -> None:
        r = radii[:, None]
        r2 = r * r
        self.squares: FloatArray = heights * heights
        tangency = self.squares - r2
        near = np.abs(tangency) < TANGENCY_MIN
        if np.count_nonzero(near):
            tangency = np.where(near, np.copysign(TANGENCY_MIN, tangency), tangency)
            self.squares = np.maximum(tangency + r2, 0.0)
        self.h: FloatArray = np.sqrt(self.squares)
        self._r = r
        self._cut = tangency < 0.0  # lines that meet the coverage circle
        c = np.sqrt(np.abs(tangency))
        powers = np.empty((len(heights), 3, heights.shape[1]))
        q = np.divide(1.0, tangency, out=powers[:, 0])
        np.multiply(q, q, out=powers[:, 1])
        np.multiply(q, powers[:, 1], out=powers[:, 2])
        coefficients = _coefficients(np.asarray(radii, dtype=np.float64).tobytes())
        self._constant, self._linear, self._square, angle = (coefficients @ powers).swapaxes(0, 1)
        self._slope, self._angle = (self.h + r) / c, angle / c

    def primitives(self, s: FloatArray, rho: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the primitives of s / gap^4 and of 1 / gap^4, E(s), at distance rho from the center; E is odd."""
        v = 1.0 / (rho - self._r)
        rational = s * v * (self._constant + v * (self._linear + v * self._square))
        g = self._slope * s / (rho + self.h)
        angle = np.arctan(g)
        if np.count_nonzero(self._cut):
            beyond = g[..., self._cut]
            size = np.abs(beyond)
            angle[..., self._cut] = np.copysign(0.5 * np.log(np.maximum(size - 1.0, _TINY) / (size + 1.0)), -beyond)
        return v * v * (self._r / -3.0 * v - 0.5), rational + self._angle * angle


@lru_cache(maxsize=64)
def _coefficients(radii: bytes) -> FloatArray:
    """Return how E(s) depends on the powers 1, 2 and 3 of q = 1 / T, (n, 4, 3), for robots of n coverage radii.

    The rows: the coefficients of s v, s v^2 and s v^3, and that of c K(s) / 2.
    """
    r = np.frombuffer(radii)
    nothing, one = np.zeros_like(r), np.ones_like(r)
    rows = (
        (nothing, 13.0 / 6.0 * r, 2.5 * r**3),
        (0.5 * one, 5.0 / 6.0 * r**2, nothing),
        (r / 3.0, nothing, nothing),
        (one, 6.0 * r**2, 5.0 * r**4),
    )
    return np.moveaxis(np.array(rows), 2, 0).copy()
