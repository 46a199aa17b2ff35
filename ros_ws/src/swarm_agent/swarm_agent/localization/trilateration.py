"""Position from measured distances to beacons whose positions are known (thesis section 3.1.1, erratum E9)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

import numpy as np

from swarm_msgs_py.types import FloatArray

MIN_BEACONS = 3
"""Two circles meet in two points."""

MIN_SPREAD = 0.1
"""Beacons whose cloud is thinner than this, smallest to largest singular value, count as collinear: a linear solution
would turn range errors of 2 m into position errors of hundreds of meters."""

MIRROR_SIGMAS = 3.0
"""How many standard deviations of the propagated position must fit between it and the line of the beacons."""

REFINEMENTS = 5
"""Gauss-Newton steps after the linear solution, which is good enough for these few."""

ITERATIONS_MAX = 40
"""The same where there is no linear solution to start from."""

STEP_MAX = 10.0
"""Longest Gauss-Newton step [m]; near a singular geometry the model behind a longer one does not hold."""

CONVERGED = 1e-7
"""A step shorter than this ends the iteration [m]; the next one would be lost in rounding."""

DILUTION_MAX = 1e3
"""Largest amplification of range errors into position errors that is called a fix, however exact the ranges."""

_TINY = float(np.finfo(np.float64).tiny)


class Case(Enum):
    """How the position was found (thesis section 3.1.1)."""

    EXACT = auto()
    """Three beacons that span the plane."""
    OVERDETERMINED = auto()
    """More than three that span the plane."""
    COLLINEAR = auto()
    """Beacons (nearly) on a line: found by iteration, on the propagated position's side of the line."""


class Rejection(Enum):
    """Why there is no position."""

    TOO_FEW = auto()
    """Fewer than three beacons."""
    MIRROR = auto()
    """Beacons on a line, and the propagated position does not say on which side of it the robot is."""
    SINGULAR = auto()
    """The ranges do not determine a point: beacons in one spot, robot on their line, no convergence, not finite, or an
    ellipse of uncertainty so long that the circles bend away from it."""


@dataclass(frozen=True, slots=True, eq=False)
class Trilateration:
    """A measured position.

    Attributes
    ----------
    position : (2,) array
        World frame [m].
    covariance : (2, 2) array
        Of the position, from the range noise and the geometry of the beacons [m^2].
    squared_residual : float
        Sum over all beacons of the squared differences between their distances from `position` and the ranges [m^2].
        Divided by the variance of a range it is chi-square with m - 2 degrees of freedom, unless a beacon lies.
    case : Case
    """

    position: FloatArray
    covariance: FloatArray
    squared_residual: float
    case: Case


class _Fit(NamedTuple):
    """A point and how it fits the ranges: J^T J, J^T f and the cost f^T f; f are the residuals, J is their Jacobian."""

    x: float
    y: float
    xx: float
    xy: float
    yy: float
    x_residual: float
    y_residual: float
    cost: float

    def dilutes_less_than(self, square: float) -> bool:
        """Return whether range errors are amplified by less than the root of `square`; False if not finite."""
        # The amplification is one over the root of the smallest eigenvalue of J^T J. That is the determinant over the
        # largest: no difference of nearly equal numbers.
        determinant = self.xx * self.yy - self.xy * self.xy
        return determinant * square > _largest_eigenvalue(self.xx, self.xy, self.yy)

    def step(self) -> tuple[float, float]:
        """Return the Gauss-Newton step -(J^T J)^-1 J^T f, at most `STEP_MAX` long [m]."""
        scale = -1.0 / (self.xx * self.yy - self.xy * self.xy)
        x = scale * (self.yy * self.x_residual - self.xy * self.y_residual)
        y = scale * (self.xx * self.y_residual - self.xy * self.x_residual)
        return _shortened(x, y, STEP_MAX)

    def covariance(self, range_sigma: float) -> FloatArray:
        """Return sigma^2 (J^T J)^-1 (2, 2) [m^2]."""
        scale = range_sigma * range_sigma / (self.xx * self.yy - self.xy * self.xy)
        return np.array(((self.yy * scale, -self.xy * scale), (-self.xy * scale, self.xx * scale)))


class _Side(NamedTuple):
    """The half-plane ahead of a line through the origin, by its unit normal."""

    normal_x: float
    normal_y: float

    def folded(self, x: float, y: float) -> tuple[float, float]:
        """Return the point, or its mirror image if it lies behind the line."""
        behind = min(0.0, self.normal_x * x + self.normal_y * y)
        return x - 2.0 * behind * self.normal_x, y - 2.0 * behind * self.normal_y


class _Circles:
    """The circles of equal range around the beacons, with the beacons' center as the origin.

    Parameters
    ----------
    beacons : (m, 2) array
    ranges : (m,) array
    """

    def __init__(self, beacons: FloatArray, ranges: FloatArray) -> None:
        count = len(beacons)
        self.center: FloatArray = beacons.sum(axis=0) / count
        self._x, self._y = (beacons - self.center).T
        self._ranges = ranges
        self._table = np.empty((3, count))  # scratch, written anew by whoever asks for its products
        self._rows, self._transposed = tuple(self._table), self._table.T
        self.reach = math.sqrt(float(ranges @ ranges) / count)
        """Root mean square of the ranges [m]."""
        self._table[0], self._table[1] = self._x, self._y
        self._table[2] = self._x * self._x + self._y * self._y - ranges * ranges
        (self._xx, self._xy, self._x_rhs), (_, self._yy, self._y_rhs), _ = self._products()

    def span_the_plane(self) -> bool:
        """Return whether the beacons' cloud is thick enough for a linear solution."""
        # Singular values of the centered beacons. Those of A in the thesis depend on which beacon comes first.
        limit = MIN_SPREAD * _largest_eigenvalue(self._xx, self._xy, self._yy)
        return self._xx * self._yy - self._xy * self._xy > limit * limit  # a power of floats may raise

    def linear_solution(self) -> tuple[float, float]:
        """Return the least-squares solution of the linear equations, thesis eqs. (3.7)-(3.17).

        They are differences of circle equations. Here the mean of all circles is subtracted, not the first one: the
        same point for three beacons, and independent of the beacons' order for more.
        """
        scale = 0.5 / (self._xx * self._yy - self._xy * self._xy)
        x = scale * (self._yy * self._x_rhs - self._xy * self._y_rhs)
        y = scale * (self._xx * self._y_rhs - self._xy * self._x_rhs)
        return x, y

    def side_of(self, x: float, y: float) -> _Side | None:
        """Return the side of the beacons' line (of least squares) on which a point lies; None without such a line."""
        if not self._xx + self._yy > 0.0:
            return None
        angle = 0.5 * math.atan2(2.0 * self._xy, self._xx - self._yy)
        normal_x, normal_y = -math.sin(angle), math.cos(angle)
        sign = math.copysign(1.0, normal_x * x + normal_y * y)
        return _Side(sign * normal_x, sign * normal_y)

    def fit(self, x: float, y: float) -> _Fit:
        """Return how a point fits the ranges."""
        east, north, residual = self._rows
        np.subtract(x, self._x, out=east)
        np.subtract(y, self._y, out=north)
        distances = np.hypot(east, north)
        np.subtract(distances, self._ranges, out=residual)
        # On a beacon its circle has no direction; the row is zero then and adds no information.
        np.maximum(distances, _TINY, out=distances)
        east /= distances
        north /= distances
        (xx, xy, x_residual), (_, yy, y_residual), (_, _, cost) = self._products()
        return _Fit(x, y, xx, xy, yy, x_residual, y_residual, cost)

    def _products(self) -> list[list[float]]:
        """Return the inner products of the rows of the table: all sums that are needed, at once."""
        products: list[list[float]] = (self._table @ self._transposed).tolist()
        return products


@np.errstate(all="ignore")  # what overflows is rejected at the end
def trilaterate(
    beacons: FloatArray,
    ranges: FloatArray,
    propagated: FloatArray,
    propagated_covariance: FloatArray,
    range_sigma: float,
) -> Trilateration | Rejection:
    """Return the position that explains the ranges best in the sense of least squares, or why there is none.

    A Gauss-Newton iteration refines the linear solution or, if the beacons are (nearly) on a line, the propagated
    position. Thin clouds of beacons that are not quite lines have two places that explain noisy ranges almost equally
    well, and the linear solution may lie near the wrong one; so there, too, the iteration starts from the propagated
    position if belief and ranges together make that the more probable of the two.

    A step that would raise the cost is halved until it does not, so that contradictory ranges cannot make the iteration
    oscillate: the answer is the best position seen. It is taken after at most `REFINEMENTS` steps; for beacons on a
    line, the iteration must converge within `ITERATIONS_MAX`, or there is no answer.

    Parameters
    ----------
    beacons : (m, 2) array
        Positions of the beacons [m]. Their order does not matter.
    ranges : (m,) array
        Measured distance to each [m].
    propagated : (2,) array
        Where the robot believes to be before this measurement [m]. It chooses between mirror images and does not pull
        the answer towards itself.
    propagated_covariance : (2, 2) array
        Of that belief [m^2]; infinite variances say that there is none.
    range_sigma : float
        Standard deviation of a range [m]; 0 for exact ranges.

    Returns
    -------
    Trilateration or Rejection
        A `Trilateration` is always finite.

    References
    ----------
    .. [1] Thesis section 3.1.1, eqs. (3.2)-(3.27); spec section 4 for the numerical rules and the covariance.
    """
    count = len(beacons)
    if count < MIN_BEACONS:
        return Rejection.TOO_FEW
    circles = _Circles(beacons, ranges)
    x, y = (propagated - circles.center).tolist()
    side = None
    if circles.span_the_plane():
        case = Case.EXACT if count == MIN_BEACONS else Case.OVERDETERMINED
        start = _more_probable(circles, (x, y), propagated_covariance, range_sigma)
    else:
        case, start = Case.COLLINEAR, circles.fit(x, y)
        side = circles.side_of(x, y)
        if side is not None and not _is_clear_of_the_line(side, x, y, propagated_covariance):
            return Rejection.MIRROR
    fit = _refined(circles, start, side)
    # Over one standard deviation s of the position, circles of radius r bend by s^2 / 2r. Beyond half a range error,
    # neither the covariance nor a filter that trusts it means anything.
    if fit is None or not fit.dilutes_less_than(circles.reach / max(range_sigma, _TINY)):
        return Rejection.SINGULAR
    position, covariance = circles.center + np.array((fit.x, fit.y)), fit.covariance(range_sigma)
    if not math.isfinite(sum(position.tolist()) + float(covariance.sum()) + fit.cost):
        return Rejection.SINGULAR
    return Trilateration(position, covariance, fit.cost, case)


def dilution(beacons: FloatArray, position: FloatArray) -> FloatArray | None:
    """Return (J^T J)^-1 at a position, (2, 2): its covariance for ranges of unit variance. None if it does not exist.

    Parameters
    ----------
    beacons : (m, 2) array
        Positions of the beacons [m].
    position : (2,) array
        Where the ranges are taken [m].
    """
    fit = _Circles(beacons, np.zeros(len(beacons))).fit(*(position - beacons.sum(axis=0) / len(beacons)).tolist())
    return fit.covariance(1.0) if fit.dilutes_less_than(DILUTION_MAX**2) else None


def _more_probable(
    circles: _Circles, propagated: tuple[float, float], covariance: FloatArray, range_sigma: float
) -> _Fit:
    """Return the fit of the linear solution or of the propagated position, whichever belief and ranges favor."""
    linear, believed = circles.fit(*circles.linear_solution()), circles.fit(*propagated)
    (xx, xy), (_, yy) = covariance.tolist()
    x, y = linear.x - believed.x, linear.y - believed.y
    determinant = xx * yy - xy * xy
    surprise = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant if determinant > 0.0 else 0.0
    # Twice the negative logarithms of the probabilities, times the variance of a range, which may be zero. What is not
    # finite is not smaller.
    return believed if believed.cost < linear.cost + range_sigma * range_sigma * surprise else linear


def _is_clear_of_the_line(side: _Side, x: float, y: float, covariance: FloatArray) -> bool:
    """Return whether the ellipse of `MIRROR_SIGMAS` around a point stays on one side; False if not finite."""
    (xx, xy), (_, yy) = covariance.tolist()
    normal_x, normal_y = side
    variance = normal_x * normal_x * xx + 2.0 * normal_x * normal_y * xy + normal_y * normal_y * yy
    distance = normal_x * x + normal_y * y
    return distance > 0.0 and distance * distance > MIRROR_SIGMAS**2 * variance


def _refined(circles: _Circles, fit: _Fit, side: _Side | None) -> _Fit | None:
    """Return the end of the Gauss-Newton iteration from `fit`, which never leaves `side`; None if it fails."""
    if not fit.dilutes_less_than(DILUTION_MAX**2):
        return None
    step_x, step_y = fit.step()
    for _ in range(ITERATIONS_MAX if side else REFINEMENTS):
        x, y = fit.x + step_x, fit.y + step_y
        if side:
            # The mirror image of a point fits (nearly) as well, so a step across the line is as good folded back.
            x, y = side.folded(x, y)
        if not math.hypot(step_x, step_y) > CONVERGED:
            return fit._replace(x=x, y=y)
        candidate = circles.fit(x, y)
        if candidate.cost < fit.cost and candidate.dilutes_less_than(DILUTION_MAX**2):
            fit = candidate
            step_x, step_y = fit.step()
        else:
            step_x, step_y = 0.5 * step_x, 0.5 * step_y
    return None if side else fit


def _largest_eigenvalue(xx: float, xy: float, yy: float) -> float:
    return 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)


def _shortened(x: float, y: float, length_max: float) -> tuple[float, float]:
    """Return the vector, scaled down if it is longer than `length_max`."""
    length = math.hypot(x, y)
    scale = length_max / length if length > length_max else 1.0
    return scale * x, scale * y
