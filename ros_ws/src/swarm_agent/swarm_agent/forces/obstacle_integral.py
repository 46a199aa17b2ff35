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
        along, across = self._integrate(np.stack([first, first + edges.lengths]), _Lines(heights, r), r)
        push: FloatArray = -(along @ edges.tangents) - (across * heights) @ edges.normals
        return push

    def _integrate(self, ends: FloatArray, lines: _Lines, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the integrals of s / gap^4 and of 1 / gap^4 from s1 to s2, the rows of `ends`; (n, e) each."""
        limit = r + self._gap_min
        reach = np.sqrt(np.maximum(limit * limit - lines.squares, 0.0))  # s0: the gap is clamped for |s| below it
        # Ends on one side of the clamped stretch have it in common, and it cancels.
        is_clamped = bool(((reach > 0.0) & (ends[0] < reach) & (ends[1] > -reach)).any())
        rho, sizes = np.sqrt(lines.squares + ends * ends), np.abs(ends)
        if is_clamped:
            rho, sizes = np.maximum(rho, limit), np.maximum(sizes, reach)
        inverse = 1.0 / (rho - r)
        along = inverse * inverse * (r / -3.0 * inverse - 0.5)
        across = lines.primitive(sizes, rho, inverse)
        if is_clamped:
            nearest = np.maximum(lines.h, limit)
            across -= lines.primitive(reach, nearest, 1.0 / (nearest - r))
        across *= np.sign(ends)  # the integral from 0 is odd
        if is_clamped:
            inner = np.clip(ends, -reach, reach) / self._gap_min**2
            along += 0.5 * inner * inner
            across += inner / self._gap_min**2
        return along[1] - along[0], across[1] - across[0]


class _Lines:
    """What E(s) needs of the lines of all edges, (n, e), for robots of (n, 1) coverage radii r."""

    def __init__(self, heights: FloatArray, r: FloatArray) -> None:
        r2 = r * r
        tangency = heights * heights - r2
        near = np.abs(tangency) < TANGENCY_MIN
        if near.any():
            tangency[near] = np.copysign(TANGENCY_MIN, tangency[near])
        self.squares = np.maximum(tangency + r2, 0.0)
        self.h = np.sqrt(self.squares)
        self._r = r
        self._cut = tangency < 0.0  # lines that meet the coverage circle
        c = np.sqrt(np.abs(tangency))
        q = 1.0 / tangency
        w = r2 * q
        self._slope = (self.h + r) / c
        self._constant, self._linear, self._scale = (r * q) * (13.0 + 15.0 * w), 3.0 + 5.0 * w, q / 6.0
        self._angle = (1.0 + w) * (1.0 + 5.0 * w) * q / c

    def primitive(self, s: FloatArray, rho: FloatArray, v: FloatArray) -> FloatArray:
        """Return E(s) for s >= 0, its distance rho and its inverse gap v."""
        rational = s * v * self._scale * (self._constant + v * (self._linear + 2.0 * self._r * v))
        g = self._slope * s / (rho + self.h)
        angle = np.arctan(g)
        if self._cut.any():
            cut = np.broadcast_to(self._cut, s.shape)
            angle[cut] = 0.5 * np.log(np.maximum(g[cut] - 1.0, _TINY) / (g[cut] + 1.0))
        primitive: FloatArray = rational + self._angle * angle
        return primitive
