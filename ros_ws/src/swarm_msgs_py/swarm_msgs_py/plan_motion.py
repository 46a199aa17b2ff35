"""Where the shape and the goals of a plan are at a time: for all who follow it, the same at the same tick.

Between the knots of its track a goal goes along a cubic with continuous velocity, which is at rest at both ends and
never leaves the range between two knots, along x and along y.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely

from swarm_msgs_py.geometry.morphing import morph_between
from swarm_msgs_py.messages.bodies import Motion, Plan
from swarm_msgs_py.types import FloatArray

CENTIMETER_M = 0.01
OUTLINE_M = 0.02  # [m]; what a beginning may leave out of a contour


def is_moving(plan: Plan, tick: float) -> bool:
    """Return whether the shape of a plan is on its way at a tick."""
    motion = plan.motion
    return motion is not None and motion.begins <= tick < motion.ends


def contour_at(plan: Plan, tick: float) -> FloatArray:
    """Return the contour at a tick; the number of its points changes with time.

    Parameters
    ----------
    plan : Plan
    tick : float
        It need not be whole.

    Returns
    -------
    (p, 2) array
        Counter-clockwise, read-only [m].

    Raises
    ------
    ShapeError
        If the motion of the plan is none: the contour would cross itself on the way.
    """
    motion = plan.motion
    if motion is None or tick >= motion.ends:
        return plan.contour
    if tick <= motion.begins:
        return motion.start
    start, target = np.ascontiguousarray(motion.start).tobytes(), np.ascontiguousarray(plan.contour).tobytes()
    return _contour(start, target, motion.rotation_rad, (tick - motion.begins) / motion.ticks)


def outline_at(plan: Plan, tick: float) -> FloatArray:
    """Return the contour at a tick as another motion may begin with it: in whole centimeters, with no idle corners.

    Parameters
    ----------
    plan : Plan
    tick : float

    Returns
    -------
    (k, 2) array
        Simple and counter-clockwise, less than `OUTLINE_M` from the contour (but for what is narrower than that) [m];
        that of the plan, if its shape is at rest.

    Raises
    ------
    ShapeError
        As `contour_at`.
    """
    contour = contour_at(plan, tick)
    motion = plan.motion
    if motion is None or not motion.begins < tick < motion.ends:
        return contour
    # Where a neck is about to part, rounding may pinch it off; the larger part goes on.
    whole = shapely.set_precision(shapely.Polygon(contour).simplify(OUTLINE_M / 2.0), CENTIMETER_M)
    largest = max(shapely.get_parts(whole), key=lambda part: float(part.area))
    ring = shapely.get_coordinates(shapely.geometry.polygon.orient(largest).exterior)[:-1]
    outline: FloatArray = ring.round(2) + 0.0  # no negative zeros
    return outline


def goals_at(plan: Plan, tick: float) -> FloatArray:
    """Return the goals at a tick, (n, 2) in the order of their ids, read-only [m].

    A plan that is not completed yet (`swarm_msgs_py.plan_goals`) has goals at rest.
    """
    motion = plan.motion
    if motion is None or tick >= motion.ends or len(motion.track) < 2:
        return plan.goals
    return _way(motion).goals(max(tick - motion.begins, 0.0) / motion.ticks)


def goal_rates_at(plan: Plan, tick: float) -> FloatArray:
    """Return how fast each goal moves at a tick, (n, 2) [m per tick]: zero for those at rest."""
    motion = plan.motion
    if motion is None or not is_moving(plan, tick) or len(motion.track) < 2:
        return np.zeros_like(plan.goals)
    return _way(motion).rates((tick - motion.begins) / motion.ticks) / motion.ticks


class _Way:
    """Goals as cubic Hermite splines over shares of the time.

    Slopes at inner knots are harmonic means of those on both sides, or zero where these have different signs, so that
    nothing overshoots.

    Parameters
    ----------
    track : (m, n, 2) array
        m >= 2 [m].

    References
    ----------
    .. [1] F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM
       Journal on Scientific and Statistical Computing 5(2), 1984.
    """

    def __init__(self, track: FloatArray) -> None:
        self._track = track
        self._rises = np.diff(track, axis=0)
        before, after = self._rises[:-1], self._rises[1:]
        product, total = before * after, before + after
        self._slopes = np.zeros_like(track)  # per interval between knots
        np.divide(2.0 * product, total, out=self._slopes[1:-1], where=product > 0.0)

    def goals(self, share: float) -> FloatArray:
        """Return the goals after a share of the time, (n, 2) [m]."""
        knot, t = self._place(share)
        first, last, rise = self._slopes[knot], self._slopes[knot + 1], self._rises[knot]
        goals: FloatArray = self._track[knot] + t * (
            first + t * ((3.0 * rise - 2.0 * first - last) + t * (first + last - 2.0 * rise))
        )
        goals.flags.writeable = False
        return goals

    def rates(self, share: float) -> FloatArray:
        """Return the change of the goals per share of the time, (n, 2) [m]."""
        knot, t = self._place(share)
        first, last, rise = self._slopes[knot], self._slopes[knot + 1], self._rises[knot]
        bend = 2.0 * (3.0 * rise - 2.0 * first - last) + 3.0 * t * (first + last - 2.0 * rise)
        rates: FloatArray = len(self._rises) * (first + t * bend)
        return rates

    def _place(self, share: float) -> tuple[int, float]:
        """Return the knot before a share of the time, and how far it is from there to the next one, 0 to 1."""
        place = share * len(self._rises)
        knot = min(int(place), len(self._rises) - 1)
        return knot, place - knot


@lru_cache(maxsize=256)  # motions are told apart by identity: many who hold the same plan share one
def _way(motion: Motion) -> _Way:
    return _Way(motion.track)


@lru_cache(maxsize=64)  # all who share a process ask for the same tick
def _contour(start: bytes, target: bytes, rotation_rad: float, share: float) -> FloatArray:
    first, last = (np.frombuffer(points).reshape(-1, 2) for points in (start, target))
    contour = morph_between(first, last, rotation_rad).at(share)
    contour.flags.writeable = False
    return contour
