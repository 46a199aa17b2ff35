"""Contours on their way from one shape to another (spec section 13)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from swarm_msgs_py.errors import ShapeError, SwarmError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.geometry.correspondence import matched, resampled
from swarm_msgs_py.types import FloatArray

CHECKS = 48  # of the contour on its way, at equal shares of time
STIFF = 0.5  # cost of a piece that becomes a point, where the usual one lets the contour cross itself
POINTS = 128  # of contours whose points are matched by their place along the contour alone
ROUNDS = 60  # of the fit of the common motion
NEAR = 1e-6  # [m]; points that the common motion brings this near to their places weigh no more for being nearer
STILL = 1e-3  # [m]; a common motion that ends nearer than this to where it began is none
SAME_SIZE = 1e-3  # share by which the common motion changes lengths, if it does
AREA_MIN = 0.01  # share of its area that a contour keeps before it is blown up again; less is a collapse
SAME_POINT = 1e-9  # [m]; points of a contour that coincide are one
CORNERS_MIN = 3
GEOMETRY_ERRORS = (SwarmError, ArithmeticError, LookupError, RuntimeError, ValueError, shapely.errors.ShapelyError)
"""What geometry raises on polygons that are none, as a forged plan may have them. Nothing else is expected of it."""


class Morph:
    """A contour that moves from a start to a target, slowly at first and in the end.

    Points that belong together (`geometry.correspondence`) move toward each other on straight lines, seen in a frame
    that moves with the center of area and turns by `rotation_rad` on the way. The area changes in proportion.

    Parameters
    ----------
    start : (k, 2) array
        Simple contour, counter-clockwise [m].
    target : (m, 2) array
        Likewise.
    rotation_rad : float
        By how much the contour turns on the way, counter-clockwise [rad].

    Raises
    ------
    ShapeError
        If the contour would cross itself on the way.

    Attributes
    ----------
    centers : tuple of (2,) array
        Centers of area of the start and of the target [m].
    rotation_rad : float
    """

    def __init__(self, start: FloatArray, target: FloatArray, rotation_rad: float = 0.0) -> None:
        self._start, self._target, self.rotation_rad = start, target, rotation_rad
        self.centers = area_centroid(start), area_centroid(target)
        self._areas = signed_area(start), signed_area(target)
        one, other = start - self.centers[0], _turned(target - self.centers[1], -rotation_rad)
        for match in (matched, _matched_stiffly, _matched_evenly):
            self._first, self._last = match(one, other)
            if self._is_simple():
                break
        else:
            raise ShapeError(
                "the contour would cross itself on the way to this shape; say by how much it turns, or go by way of a"
                " shape in between"
            )
        self._growth, self._shift = self._common_motion()
        self._is_resized = abs(abs(self._growth) - 1.0) > SAME_SIZE
        moved = self._common(1.0, self._common(0.0, start, inverse=True))
        # What turns by 360 degrees ends where it began as well, but not without going anywhere.
        self._is_still = rotation_rad == 0.0 and float(np.abs(moved - start).max()) < STILL
        # The target less the common motion, and which edges of both are no part of the other, by their first points.
        self._end = _real((_complex(self._last) - self._shift) / self._growth)
        off = np.maximum(_distances(self._first, self._end), _distances(self._end, self._first)) > STILL
        self._changing = off | np.roll(off, -1)

    def at(self, share: float) -> FloatArray:
        """Return the contour after a share of the time, (p, 2) counter-clockwise [m]; 0: the start, 1: the target."""
        if share <= 0.0:
            return self._start
        if share >= 1.0:
            return self._target
        contour = self._center(share) + _turned(self._size(share) * self._blended(share), self._turn(share))
        distinct = (np.abs(contour - np.roll(contour, 1, axis=0)) > SAME_POINT).any(axis=1)
        return contour[distinct]

    def carried(self, points: FloatArray, before: float, after: float) -> FloatArray:
        """Return points that take part in what is common to the motion of most of the contour.

        That is a translation, a turn, and a change of size. Where most of the contour rests, so do the points, however
        far the rest of it goes.

        Parameters
        ----------
        points : (n, 2) array
            Where they are [m].
        before, after : float
            Shares of the time.

        Returns
        -------
        (n, 2) array
            [m].
        """
        if self._is_still:
            return points
        return self._common(after, self._common(before, points, inverse=True))

    def distances_to_change(self, points: FloatArray) -> FloatArray:
        """Return how far points of the start are from where the contour does more than what is common, (n,) [m].

        Infinite if it does so nowhere. Where such a piece will be counts as much as where it is.

        Parameters
        ----------
        points : (n, 2) array
            [m].
        """
        if not self._changing.any():
            return np.full(len(points), np.inf)
        pieces = [
            np.stack([places, np.roll(places, -1, axis=0)], axis=1)[self._changing]
            for places in (self._first, self._end)
        ]
        edges = shapely.union_all(shapely.linestrings(np.concatenate(pieces) + self.centers[0]))
        distances: FloatArray = shapely.distance(edges, shapely.points(points))
        return distances

    def _common_motion(self) -> tuple[complex, complex]:
        """Return growth and shift of the motion that most of the contour shares, in its own frame; else of its area."""
        exact = _most_common(self._first, self._last)
        return exact or (complex((self._areas[1] / self._areas[0]) ** 0.5), 0.0j)

    def _common(self, share: float, points: FloatArray, *, inverse: bool = False) -> FloatArray:
        """Return where points of the start are, in its frame, after a share of the common motion; or the inverse."""
        blend = smooth_step(share)
        growth, shift = (1.0 - blend) + blend * self._growth, blend * self._shift
        size = self._size(share) if self._is_resized else 1.0
        if inverse:
            own = _complex(_turned(points - self._center(share), -self._turn(share))) / size
            return _real((own - shift) / growth)
        own = growth * _complex(points) + shift
        return self._center(share) + _turned(_real(size * own), self._turn(share))

    def _blended(self, share: float) -> FloatArray:
        blend = smooth_step(share)
        blended: FloatArray = (1.0 - blend) * self._first + blend * self._last
        return blended

    def _size(self, share: float) -> float:
        """Return the factor that gives the blended contour its area."""
        blend = smooth_step(share)
        area = (1.0 - blend) * self._areas[0] + blend * self._areas[1]
        return float(np.sqrt(area / max(signed_area(self._blended(share)), AREA_MIN * area)))

    def _center(self, share: float) -> FloatArray:
        blend = smooth_step(share)
        center: FloatArray = (1.0 - blend) * self.centers[0] + blend * self.centers[1]
        return center

    def _turn(self, share: float) -> float:
        return smooth_step(share) * self.rotation_rad

    def _is_simple(self) -> bool:
        shares = (np.arange(CHECKS - 1) + 1.0) / CHECKS
        return all(
            signed_area(self._blended(share)) > 0.0 and shapely.Polygon(self.at(share)).is_valid for share in shares
        )


def morph_between(start: FloatArray, target: FloatArray, rotation_rad: float = 0.0) -> Morph:
    """Return the morph between two contours; per process it is made once, or found to be none.

    Raises
    ------
    ShapeError
        If one of them is no simple contour, or the contour would cross itself on the way.
    """
    morph = _morph(np.ascontiguousarray(start).tobytes(), np.ascontiguousarray(target).tobytes(), rotation_rad)
    if isinstance(morph, str):
        raise ShapeError(morph)
    return morph


@lru_cache(maxsize=8)
def _morph(start: bytes, target: bytes, rotation_rad: float) -> Morph | str:
    """Return the morph, or why there is none: all robots of a process would ask again."""
    first, last = (np.frombuffer(points).reshape(-1, 2) for points in (start, target))
    if not (is_contour(first) and is_contour(last)):
        return "a motion between contours that cross themselves, run clockwise or enclose nothing"
    try:
        return Morph(first, last, rotation_rad)
    except ShapeError as error:
        return str(error)
    except GEOMETRY_ERRORS as error:
        return f"cannot move ({type(error).__name__}: {error}); simplify it"


def is_contour(points: FloatArray) -> bool:
    """Return whether (k, 2) points are a simple contour, counter-clockwise, around some area."""
    if len(points) < CORNERS_MIN or signed_area(points) <= 0.0:
        return False
    return bool(shapely.Polygon(points).is_valid)


def _matched_stiffly(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points matched so that new pieces come out of single points, and do not fold what is beside them."""
    return matched(one, other, STIFF)


def _matched_evenly(one: FloatArray, other: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points at equal shares of both lengths, those of the other shifted so that they are as near as can be."""
    first, last = resampled(one, POINTS), resampled(other, POINTS)
    costs = [float(((np.roll(last, -shift, axis=0) - first) ** 2).sum()) for shift in range(POINTS)]
    return first, np.roll(last, -int(np.argmin(costs)), axis=0)


def _most_common(first: FloatArray, last: FloatArray) -> tuple[complex, complex] | None:
    """Return the complex growth a and shift b by which a z + b is where more than half of the contour goes, if any are.

    The least sum of distances, each counted by the length of contour that its point stands for, is exact for the
    majority, which a least sum of squares is not; it is found by iteratively reweighted least squares.
    """
    one, other = _complex(first), _complex(last)
    steps = np.abs(np.roll(one, -1) - one) + np.abs(np.roll(other, -1) - other)
    lengths = steps + np.roll(steps, 1)
    weights, growth, shift = lengths, 1.0 + 0.0j, 0.0j
    for _ in range(ROUNDS):
        total = weights.sum()
        middle, end = (weights * one).sum() / total, (weights * other).sum() / total
        arms = one - middle
        growth = complex((weights * arms.conj() * (other - end)).sum() / (weights * np.abs(arms) ** 2).sum())
        shift = complex(end - growth * middle)
        distances = np.abs(growth * one + shift - other)
        weights = lengths / np.maximum(distances, NEAR)
    return (growth, shift) if lengths[distances < STILL].sum() > 0.5 * lengths.sum() else None


def _distances(points: FloatArray, contour: FloatArray) -> FloatArray:
    """Return how far (n, 2) points are from a contour, (n,) [m]."""
    distances: FloatArray = shapely.distance(shapely.LinearRing(contour), shapely.points(points))
    return distances


def smooth_step(share: float) -> float:
    """Return how far a motion is that begins and ends slowly, after a share of its time (spec section 13)."""
    return share * share * (3.0 - 2.0 * share)


def _turned(points: FloatArray, angle: float) -> FloatArray:
    if not angle:
        return points
    (x, y), cosine, sine = points.T, np.cos(angle), np.sin(angle)
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y])


def _complex(points: FloatArray) -> NDArray[np.complex128]:
    return points[:, 0] + 1j * points[:, 1]


def _real(points: NDArray[np.complex128]) -> FloatArray:
    return np.column_stack([points.real, points.imag])
