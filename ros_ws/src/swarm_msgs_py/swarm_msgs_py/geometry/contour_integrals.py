"""What a closed contour is to a point: inside or not, how far, and the thesis' line integrals in closed form.

The thesis resamples contours to points 0.01 m apart and sums over them. Here every integral is exact per edge, so it is
right at any distance from the contour and costs a hundredth.
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.geometry.contour import boundary_center
from swarm_msgs_py.geometry.edges import Edges
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

HEIGHT_MIN = 1e-3  # [m]; the repulsion grows like 2/h toward an edge and must stay finite on it
_TINY = 1e-300  # [m]; a point on an edge has distances to its ends that add up to its length


class ContourIntegrals:
    """A fixed polygon whose integrals can be evaluated at many points at once.

    Parameters
    ----------
    contour : (k, 2) array
        Simple polygon, counter-clockwise [m].

    Attributes
    ----------
    length : float
        Length of the contour [m].
    center : (2,) array
        Boundary center z_c [m] (thesis eq. (3.66)).
    """

    def __init__(self, contour: FloatArray) -> None:
        self.edges = Edges((contour,))
        self.length = float(self.edges.lengths.sum())
        self.center = boundary_center(contour)
        # A sum of t f(end) - t f(start) over edges, collected per corner: it ends one edge and begins the next.
        self._turns = (np.roll(self.edges.tangents, 1, axis=0) - self.edges.tangents).T.copy()
        self._normals = self.edges.normals.T.copy()
        following = np.roll(contour, -1, axis=0)
        self.tail_heights: FloatArray = contour[(following != contour).any(axis=1), 1]
        self.heads: IntArray = np.roll(np.arange(len(self.tail_heights)), -1)  # the edge that begins where one ends

    def at(self, points: FloatArray) -> IntegralsAt:
        """Return the integrals at (n, 2) points [m]; each is computed when it is asked for."""
        return IntegralsAt(self, points)

    def sums(self, across: FloatArray, at_tails: FloatArray) -> FloatArray:
        """Return the sum over edges of shares along their normals, and over corners of shares along the turns there.

        Parameters
        ----------
        across, at_tails : (n, e) array
            Per point.

        Returns
        -------
        (n, 2) array
            Equal bits on all kinds of processors, which BLAS does not give.
        """
        sums: FloatArray = np.einsum("ne,de->nd", across, self._normals)
        sums += np.einsum("ne,de->nd", at_tails, self._turns)
        return sums


class IntegralsAt:
    """The integrals of one contour at some points.

    With z a point, zeta the running point of the contour and s the arc length. For an edge of length l with unit
    tangent t and left normal e, seen from z as s1 <= s <= s1 + l = s2 at height h, and rho the distance to an end:

    ========== ============================================ =====================================================
    attraction integral of (zeta - z) ds                    l (midpoint - z)
    repulsion  integral of (z - zeta) / |z - zeta|^3 ds     t (1/rho2 - 1/rho1) - e (s2/rho2 - s1/rho1) / h
    transition integral of (zeta - z) / |zeta - z| ds       t (rho2 - rho1) + e h ln((rho1+rho2+l) / (rho1+rho2-l))
    ========== ============================================ =====================================================

    Parameters
    ----------
    contour : ContourIntegrals
    points : (n, 2) array
        [m].

    References
    ----------
    .. [1] Thesis eqs. (3.80)-(3.90), (3.96); the sums there lack ds (errata E2 and E7 of the specification).
    """

    def __init__(self, contour: ContourIntegrals, points: FloatArray) -> None:
        self._contour = contour
        self._points = points
        self._first, self._heights = contour.edges.seen_from(points)
        self._last: FloatArray = self._first + contour.edges.lengths
        self._squares: FloatArray = self._heights * self._heights  # of the distance to the line of each edge

    def only(self, rows: IntArray) -> IntegralsAt:
        """Return the integrals at some of the points, given by their rows."""
        return IntegralsAt(self._contour, self._points[rows])

    @property
    def attraction(self) -> FloatArray:
        """Length of the contour times the way to its boundary center, (n, 2) [m^2]."""
        pull: FloatArray = self._contour.length * (self._contour.center - self._points)
        return pull

    @property
    def repulsion(self) -> FloatArray:
        """Push away from the contour, inside inward and outside outward, (n, 2) [1/m]; 2/h near a straight edge."""
        nearness = 1.0 / np.maximum(self._distances(), HEIGHT_MIN)
        heights = self._heights
        near = np.abs(heights) < HEIGHT_MIN
        if np.count_nonzero(near):
            heights = np.where(near, np.copysign(HEIGHT_MIN, heights), heights)
        across = (self._first * nearness - self._last * nearness.take(self._contour.heads, axis=1)) / heights
        return self._contour.sums(across, nearness)

    @property
    def transition(self) -> FloatArray:
        """Pull toward the contour by its length as seen from the point, (n, 2) [m]."""
        distances, lengths = self._distances(), self._contour.edges.lengths
        both = distances + distances.take(self._contour.heads, axis=1)
        across = self._heights * np.log((both + lengths) / np.maximum(both - lengths, _TINY))
        return self._contour.sums(across, distances)

    @property
    def inside(self) -> BoolArray:
        """Whether each point is inside, by the crossings of a ray along +x, (n,); on the contour either way."""
        above = self._contour.tail_heights > self._points[:, 1:]
        ends_above = above.take(self._contour.heads, axis=1)
        # A climbing edge is met by the ray of a point on its left, which sees its line at a negative height.
        met = (above != ends_above) & ((self._heights < 0.0) == ends_above)
        inside: BoolArray = np.logical_xor.reduce(met, axis=1)
        return inside

    @property
    def signed_distances(self) -> FloatArray:
        """Distance to the contour, positive inside, (n,) [m]."""
        feet = np.minimum(np.maximum(self._first, 0.0), self._last)  # nearest points of the edges, along them
        distances = np.sqrt(np.minimum.reduce(self._squares + feet * feet, axis=1))
        signed: FloatArray = np.where(self.inside, distances, -distances)
        return signed

    def _distances(self) -> FloatArray:
        """Return the distance to the tail of each edge, (n, k) [m]."""
        distances: FloatArray = np.sqrt(self._squares + self._first * self._first)
        return distances
