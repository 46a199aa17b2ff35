"""Where the shape and the goals of a plan are at a time: for all who follow it, the same at the same tick.

Between the knots of its track a goal goes on a smooth way, and is at rest at both ends (`partition.ways`).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely

from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.geometry.morphing import CORNERS_MIN, morph_between
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.partition.ways import Ways
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
        If the motion of the plan is none, as it may be in one that was forged: one of its contours is none, or it
        would cross itself on the way.
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
    return _ways(plan).goals(max(tick - motion.begins, 0.0) / motion.ticks)


def goal_rates_at(plan: Plan, tick: float) -> FloatArray:
    """Return how fast each goal moves at a tick, (n, 2) [m per tick]: zero for those at rest."""
    motion = plan.motion
    if motion is None or not is_moving(plan, tick) or len(motion.track) < 2:
        return np.zeros_like(plan.goals)
    return _ways(plan).rates((tick - motion.begins) / motion.ticks) / motion.ticks


@lru_cache(maxsize=32)  # plans are told apart by identity: many who hold the same one share the ways of its goals
def _ways(plan: Plan) -> Ways:
    motion = plan.motion
    assert motion is not None  # asked for by those who have looked
    return Ways(motion.track, (_center(motion.start), _center(plan.contour)), motion.rotation_rad)


def _center(contour: FloatArray) -> FloatArray:
    """Return the center of area; some place near by, if the contour of a forged plan has none."""
    if len(contour) < CORNERS_MIN or signed_area(contour) <= 0.0:
        return np.zeros(2)
    return np.clip(area_centroid(contour), contour.min(axis=0), contour.max(axis=0))


@lru_cache(maxsize=64)  # all who share a process ask for the same tick
def _contour(start: bytes, target: bytes, rotation_rad: float, share: float) -> FloatArray:
    first, last = (np.frombuffer(points).reshape(-1, 2) for points in (start, target))
    contour = morph_between(first, last, rotation_rad).at(share)
    contour.flags.writeable = False
    return contour
