"""Ranges as measurements of an extended Kalman filter: to beacons, and to robots that are uncertain themselves.

*The trouble with cooperation.* A robot may range to neighbors that are no beacons, and take their estimates for a
measurement. But their errors and its own are not independent: both descend from the same beacons, and from each other.
A filter that denies it counts one piece of information many times and becomes sure of a wrong place (with no beacon in
reach, fifty robots are soon certain of errors a hundred times their claim). Inflating the neighbors' covariance by a
factor only delays that; covariance intersection is safe against any correlation, and therefore gains next to nothing
from neighbors that know as little as oneself.

*What is done here.* The error of each robot is thought of as a sum: a part that it *shares* with its neighbors, because
it came from the same sources, and a part of its *own*. A robot tracks, as one number, the share of its variance that is
shared, and says it in its hellos. A range between two robots measures the difference of their errors, from which the
shared part drops out: so the range corrects the own part only, and the shared part stays, to be reduced by beacons
alone (or by a neighbor that shares less). What is taken over from a neighbor's own part, or given to it by its own
range, is shared from then on.

This is a split covariance filter (Julier and Uhlmann, 2001) whose split follows the common error and whose common parts
count as fully, positively correlated. The numbers are in docs/decisions/0007-cooperative-localization.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from swarm_agent.localization.kalman import Gaussian
from swarm_agent.localization.motion_model import POSITION, STATES
from swarm_agent.localization.observations import RangeObservations
from swarm_msgs_py.types import BoolArray, FloatArray

_SAME_FOR_ROUNDS = 40.0
"""Rounds of ranging in which the curvature's error hardly changes: as noise, it must count that many times."""

_ROOT_OF_TWO_PI = math.sqrt(2.0 * math.pi)

_TINY = 1e-12
"""Keeps quotients of variances defined where both are zero [m^2]."""

_NEAREST = math.sqrt(_TINY)
"""Keeps the direction to a neighbor in the same place defined [m]."""

_ONCE_TWICE_ONCE: FloatArray = np.array((1.0, 2.0, 1.0))
"""How often xx, xy and yy are in a quadratic form."""

_IDENTITY: FloatArray = np.eye(STATES)


@dataclass(frozen=True, slots=True)
class RangeModel:
    """What the filter believes about ranges.

    Attributes
    ----------
    sigma : float
        Standard deviation of a range [m].
    gate : float
        A range whose normalized innovation squared exceeds this is an outlier.
    inflation : float
        Factor on the own covariance of a neighbor that is no beacon: both sides forget some of their correlation.
    """

    sigma: float
    gate: float
    inflation: float


@dataclass(frozen=True, slots=True, eq=False)
class SplitBelief:
    """A belief, and how much of it is shared with the neighbors.

    Attributes
    ----------
    gaussian : Gaussian
        State as in `motion_model`.
    shared : float
        Share of the position's variance, 0 to 1.
    """

    gaussian: Gaussian
    shared: float


@dataclass(frozen=True, slots=True, eq=False)
class Fusion:
    """What became of a round of ranges.

    Attributes
    ----------
    belief : SplitBelief
        After it.
    accepted, rejected : int
        Number of ranges that were used, and of outliers.
    log_likelihood : float
        Logarithm of the probability that the belief gave to the ranges, up to a constant; an outlier counts as one at
        the gate.
    """

    belief: SplitBelief
    accepted: int
    rejected: int
    log_likelihood: float


@dataclass(frozen=True, slots=True, eq=False)
class _Sight:
    """Geometry of m ranges at the current estimate; variances along the lines of sight.

    Attributes
    ----------
    lines : (2, m) array
        Unit vectors from the neighbors to the robot.
    distances : (m,) array
        Between the estimated positions [m].
    own, their : (m,) array
        Variances of both estimates along the line [m^2].
    own_across, their_across : (m,) array
        The same across the line [m^2].
    """

    lines: FloatArray
    distances: FloatArray
    own: FloatArray
    their: FloatArray
    own_across: FloatArray
    their_across: FloatArray


def fuse_beacons(belief: SplitBelief, seen: RangeObservations, model: RangeModel, *, has_rivals: bool = True) -> Fusion:
    """Return the belief after ranges to beacons, each of them used alone: one or two are worth having (spec section 4).

    Parameters
    ----------
    belief : SplitBelief
    seen : RangeObservations
        To beacons; their errors count as independent of each other and of everything else.
    model : RangeModel
    has_rivals : bool
        Whether there are other beliefs that this one must be compared with; if not, its likelihood is left at 0.
    """
    if not len(seen):
        return Fusion(belief, 0, 0, 0.0)
    sight = _sight(belief.gaussian, seen)
    across = sight.own_across + sight.their_across
    residuals, variance, bend = _compared(seen.ranges, sight.distances, across, model.sigma)
    variance += sight.their
    noise = variance + _SAME_FOR_ROUNDS * bend
    weighed = _weighed(residuals, noise, noise + sight.own, model.gate)
    information, pull = _combined(sight.lines, weighed.weights, residuals)
    after = _informed(belief.gaussian, belief.gaussian.covariance, information, pull)
    corrected = fixed(belief, Gaussian(after.mean, after.covariance))
    position = belief.gaussian.covariance[POSITION, POSITION]
    likelihood = 0.0
    if has_rivals:
        likelihood = _log_likelihood(sight.lines, residuals, variance + bend, weighed, position, model.gate)
    return Fusion(corrected, weighed.accepted, weighed.rejected, likelihood)


def fuse_neighbors(
    belief: SplitBelief, seen: RangeObservations, model: RangeModel, *, has_rivals: bool = True
) -> Fusion:
    """Return the belief after ranges to robots that are uncertain of where they are (see the module's text).

    Parameters
    ----------
    belief : SplitBelief
    seen : RangeObservations
        To robots that are no beacons.
    model : RangeModel
    has_rivals : bool
        Whether there are other beliefs that this one must be compared with; if not, its likelihood is left at 0.
    """
    if not len(seen):
        return Fusion(belief, 0, 0, 0.0)
    prior, shared = belief.gaussian.covariance, belief.shared
    sight = _sight(belief.gaussian, seen)
    common = np.minimum(shared * sight.own, seen.shared * sight.their)
    common_across = np.minimum(shared * sight.own_across, seen.shared * sight.their_across)
    foreign = model.inflation * (sight.their - common)
    across = sight.own_across + sight.their_across - 2.0 * common_across
    residuals, variance, bend = _compared(seen.ranges, sight.distances, across, model.sigma)
    variance += foreign
    noise = variance + _SAME_FOR_ROUNDS * bend
    weighed = _weighed(residuals, noise, noise + sight.own - common, model.gate)
    weights = weighed.weights
    # Share of the prior that the neighbors have too, on the average: a range cannot see it.
    unseen = min(float(weights @ common) / max(float(weights @ sight.own), _TINY), shared)
    information, pull = _combined(sight.lines, weights, residuals)
    own = (1.0 - unseen) * prior
    after = _informed(belief.gaussian, own, information, pull)
    gaussian = Gaussian(after.mean, unseen * prior + after.covariance)

    pulls = (after.gain @ sight.lines) * weights  # (2, m): how far the position follows each residual
    taken_over = pulls * np.sqrt(foreign)
    left = _position_variance(after.covariance) / max(_position_variance(own), _TINY)
    shared_after = (unseen + (shared - unseen) * left) * prior[POSITION, POSITION] + taken_over @ taken_over.T
    if weighed.accepted:
        shared_after += _entangled(sight.lines, pulls, sight.their - common) / weighed.accepted
    position = own[POSITION, POSITION]
    likelihood = 0.0
    if has_rivals:
        likelihood = _log_likelihood(sight.lines, residuals, variance + bend, weighed, position, model.gate)
    return Fusion(_split(gaussian, shared_after), weighed.accepted, weighed.rejected, likelihood)


def _entangled(lines: FloatArray, pulls: FloatArray, own: FloatArray) -> FloatArray:
    """Return, summed over the neighbors, the covariance (2, 2) that ranging has made between two robots' errors [m^2].

    This robot follows the neighbor's own error, whose variance along the line is `own` (m,), by the gain. The neighbor,
    which ranges too, follows this robot's error by its own gain, which makes the same covariance: to first order both
    are the product of the two variances over that of the residual. Not to count it lets old errors come back as news.
    """
    dependence = (pulls * own) @ lines.T
    symmetric: FloatArray = dependence + dependence.T
    return symmetric


def fuse_walls(
    belief: SplitBelief, directions: FloatArray, offsets: FloatArray, sigma: float, gate: float
) -> SplitBelief:
    """Return the belief after walls were recognized.

    Parameters
    ----------
    belief : SplitBelief
    directions : (m, 2) array
        Unit vectors.
    offsets : (m,) array
        By how much the position is off along each of them [m].
    sigma : float
        Standard deviation of that [m].
    gate : float
        As in `RangeModel`.
    """
    own = ((directions @ belief.gaussian.covariance[POSITION, POSITION]) * directions).sum(axis=1)
    weights = (offsets**2 <= gate * (sigma**2 + own)) / sigma**2
    after = _informed(belief.gaussian, belief.gaussian.covariance, *_combined(directions.T, weights, offsets))
    return fixed(belief, Gaussian(after.mean, after.covariance))


def predicted(belief: SplitBelief, ahead: Gaussian, noise: FloatArray) -> SplitBelief:
    """Return a belief whose Gaussian was predicted to `ahead`, with process `noise`, which is the robot's own."""
    added = _position_variance(noise) / max(_position_variance(ahead.covariance), _TINY)
    return SplitBelief(ahead, belief.shared * max(1.0 - added, 0.0))


def fixed(belief: SplitBelief, after: Gaussian) -> SplitBelief:
    """Return a belief whose Gaussian was corrected to `after` by measurements that are the robot's own business.

    The correction keeps the part P+ P^-1 of every prior error, so also of the shared one.
    """
    if belief.shared == 0.0:
        return SplitBelief(after, 0.0)
    (a, b), (_, c) = belief.gaussian.covariance[POSITION, POSITION].tolist()
    determinant = a * c - b * b
    if determinant <= 0.0:  # known exactly in some direction, where a correction corrects nothing
        return SplitBelief(after, belief.shared)
    inverse = np.array(((c, -b), (-b, a))) / determinant
    posterior = after.covariance[POSITION, POSITION]
    kept = posterior @ inverse @ posterior
    return _split(after, belief.shared * kept)


@dataclass(frozen=True, slots=True, eq=False)
class _Weighed:
    is_in: BoolArray  # (m,)
    weights: FloatArray  # (m,) inverse variances of the ranges, given both positions; 0 for outliers [1/m^2]
    accepted: int
    rejected: int


@dataclass(frozen=True, slots=True, eq=False)
class _Informed:
    mean: FloatArray
    covariance: FloatArray
    gain: FloatArray  # (2, 2): how far the position follows the pull


def _sight(belief: Gaussian, seen: RangeObservations) -> _Sight:
    (x, y), ((xx, xy), (_, yy)) = belief.mean[POSITION].tolist(), belief.covariance[POSITION, POSITION].tolist()
    lines = np.empty((2, len(seen)))
    np.subtract(x, seen.positions[:, 0], out=lines[0])
    np.subtract(y, seen.positions[:, 1], out=lines[1])
    distances = np.maximum(np.hypot(lines[0], lines[1]), _NEAREST)
    lines /= distances
    products = np.empty((3, len(seen)))  # xx, xy, yy
    np.multiply(lines[0], lines, out=products[:2])
    np.multiply(lines[1], lines[1], out=products[2])
    own = np.array((xx, 2.0 * xy, yy)) @ products
    products *= seen.covariances.T
    their = np.maximum(_ONCE_TWICE_ONCE @ products, 0.0)
    own_across = np.maximum(xx + yy - own, 0.0)
    their_across = np.maximum(seen.covariances[:, 0] + seen.covariances[:, 2] - their, 0.0)
    return _Sight(lines, distances, own, their, own_across, their_across)


def _compared(
    ranges: FloatArray, distances: FloatArray, across: FloatArray, sigma: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how much longer each range is than expected [m], and two variances of that on top of the line's own [m^2].

    A range differs from the distance between two estimates for two reasons besides its noise. An error across the line
    of sight makes it longer, by across / (2 d) on the average: near a neighbor that is much, and a filter that only
    linearizes takes it for a distance. And no range is negative: where noise would make it so it is zero, a censored
    measurement, longer than its noise by itself and with less to say. What remains has the moments
    returned; the second variance is that of the errors across the line, which are the same in the next round.
    """
    square = distances * distances + across
    bent = np.sqrt(square)
    steps = bent / sigma
    positive = ndtr(steps)
    negative = 1.0 - positive
    spread = steps * positive
    density = np.exp(-0.5 * steps * steps) / _ROOT_OF_TWO_PI
    # E[r^2] - E[r]^2, over sigma^2, without the difference of two large numbers, which would be all that remains of a
    # small sigma.
    variance = positive - density * density + steps * (spread * negative + density * (negative - positive))
    residuals = (ranges - sigma * (spread + density)) / positive
    return residuals, variance * sigma**2 / (positive * positive), 0.5 * across * across / square


def _weighed(residuals: FloatArray, noise: FloatArray, variances: FloatArray, gate: float) -> _Weighed:
    """Return what ranges with these `variances` (m,) of their residuals are worth; those outside the gate nothing."""
    is_in = residuals * residuals <= gate * variances
    accepted = int(np.count_nonzero(is_in))
    return _Weighed(is_in, is_in / noise, accepted, len(is_in) - accepted)


def _combined(lines: FloatArray, weights: FloatArray, residuals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the information of all ranges on the position, (2, 2) [1/m^2], and where it pulls to, (2,) [1/m].

    Parameters
    ----------
    lines : (2, m) array
        Unit vectors along which something was measured.
    weights, residuals : (m,) array
        Inverse variances [1/m^2], and what was measured [m].
    """
    weighted = lines * weights
    information: FloatArray = weighted @ lines.T
    pull: FloatArray = weighted @ residuals
    return information, pull


def _informed(belief: Gaussian, covariance: FloatArray, information: FloatArray, pull: FloatArray) -> _Informed:
    """Return mean and covariance after information on the position, in a form that needs no inverse of it.

    One range has information along one line only, whose inverse does not exist. P+ = P - G L H P with the gain
    G = P H^T (I + L S)^-1, where S is the position's part of P and L the information; in Joseph's form, because that
    difference of nearly equal numbers would not stay positive definite where the ranges are much better than the prior.
    """
    columns = covariance[:, POSITION]
    (a, b), (c, d) = (_IDENTITY[:2, :2] + information @ covariance[POSITION, POSITION]).tolist()
    determinant = a * d - b * c
    solver = np.array(((d, -b), (-c, a))) / determinant
    gain = columns @ solver
    keep = _IDENTITY.copy()
    keep[:, POSITION] -= gain @ information
    corrected = keep @ covariance @ keep.T + gain @ information @ gain.T
    return _Informed(belief.mean + gain @ pull, 0.5 * (corrected + corrected.T), gain[POSITION])


def _log_likelihood(  # noqa: PLR0913, PLR0917 - what a correction is made of
    lines: FloatArray, residuals: FloatArray, noise: FloatArray, weighed: _Weighed, position: FloatArray, gate: float
) -> float:
    """Return log p(ranges), without constants, by the matrix determinant and inversion lemmas.

    The noise is that of one round. What counts for many rounds in a correction would make a range worthless here, and
    the hypotheses near a neighbor, where ranges bend, improbable whatever the range.
    """
    weights = weighed.is_in / noise
    information, pull = _combined(lines, weights, residuals)
    (a, b), (c, d) = (_IDENTITY[:2, :2] + information @ position).tolist()
    determinant = a * d - b * c
    explained = float(pull @ position @ np.array(((d, -b), (-c, a))) @ pull) / determinant
    surprise = float(residuals @ (weights * residuals)) + gate * weighed.rejected + float(np.log(noise).sum())
    log_likelihood: float = -0.5 * (surprise - explained + math.log(determinant))
    return log_likelihood


def _split(gaussian: Gaussian, shared: FloatArray) -> SplitBelief:
    """Return a belief whose share is that of the shared covariance (2, 2) in the direction where it is largest.

    One number stands for all directions. The mean of them would let a robot that ranges in one direction only forget
    that there its error is shared entirely.
    """
    (a, b), (_, c) = gaussian.covariance[POSITION, POSITION].tolist()
    (d, e), (_, f) = shared.tolist()
    determinant = a * c - b * b
    if determinant <= 0.0:
        return SplitBelief(gaussian, 1.0)
    half = 0.5 * (a * f - 2.0 * b * e + c * d) / determinant  # largest eigenvalue of P^-1 S
    share = half + math.sqrt(max(half * half - (d * f - e * e) / determinant, 0.0))
    return SplitBelief(gaussian, min(max(share, 0.0), 1.0))


def _position_variance(covariance: FloatArray) -> float:
    return float(covariance[0, 0] + covariance[2, 2])
