"""The goals that a plan leaves for its receivers to find: every receiver of one plan finds the same ones."""

from __future__ import annotations

import zlib
from dataclasses import replace
from functools import lru_cache

import numpy as np

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.correspondence import CORNERS_MAX
from swarm_msgs_py.geometry.morphing import GEOMETRY_ERRORS, is_contour, morph_between
from swarm_msgs_py.messages.bodies import Motion, Plan, Task
from swarm_msgs_py.partition import GoalSet, PartitionConfig, forget, partition
from swarm_msgs_py.partition.moving import track
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, IntArray

_CM_PER_M = 100.0

__all__ = ["GEOMETRY_ERRORS", "completed", "forget_goals", "goals_crc", "is_contour"]


def forget_goals() -> None:
    """Forget all goals that this process has found, so that it finds them itself if another one left it a copy."""
    _completed.cache_clear()
    _track.cache_clear()
    forget()


def completed(plan: Plan, config: PartitionConfig) -> Plan:
    """Return a plan with the goals that it leaves to be found; any other plan as it is.

    Goals follow from the plan as it was sent and from the tuning of the method alone, and are in whole centimeters. Per
    process they are computed once. If the shape moves, they are found for all of the way, from where they begin.

    Parameters
    ----------
    plan : Plan
        As decoded, so that all compute with the same numbers.
    config : PartitionConfig
        Gaps and tuning; the method is that of the plan.

    Raises
    ------
    ShapeError
        If the shape has no room for the roster, or is none, or cannot move as the plan says.
    """
    found = _completed(plan, config)
    if isinstance(found, str):
        raise ShapeError(found)
    return found


@lru_cache(maxsize=16)  # plans are told apart by identity: all robots of a process hold the same one
def _completed(plan: Plan, config: PartitionConfig) -> Plan | str:
    """Return the plan with its goals, or why there are none: all robots of a process would ask again."""
    try:
        return _with_goals(plan, config)
    except ShapeError as error:
        return str(error)


def _with_goals(plan: Plan, config: PartitionConfig) -> Plan:
    _check_motion(plan)
    if plan.task is not Task.PARTITION or plan.roster is None or plan.method is None:
        return plan
    if not is_contour(plan.contour):
        raise ShapeError("a contour that crosses itself, runs clockwise or encloses nothing cannot be partitioned")
    tuning = replace(config, method=plan.method)
    if plan.motion is not None:
        return _with_track(plan, plan.motion, plan.roster, tuning)
    try:
        goals = partition(plan.contour, plan.roster, plan.walls, tuning, keep_outs=plan.body_outlines)
    except ShapeError:
        raise
    except GEOMETRY_ERRORS as error:
        raise ShapeError(f"cannot be partitioned ({type(error).__name__}: {error}); simplify it") from error
    places: FloatArray = np.rint(goals.positions * _CM_PER_M) / _CM_PER_M
    places.flags.writeable = False
    return replace(plan, goals=places, goal_types=goals.types)


def _check_motion(plan: Plan) -> None:
    """Refuse a motion that is none, before anybody asks for a contour in the middle of it.

    Who is told the goals does not need the contours between: for him it is enough that there are two of them.

    Raises
    ------
    ShapeError
        If it does not lead from one contour to another without crossing itself.
    """
    motion = plan.motion
    if motion is None:
        return
    corners = max(len(motion.start), len(plan.contour))
    if corners > CORNERS_MAX:
        raise ShapeError(f"a contour of {corners} corners cannot move; simplify it to {CORNERS_MAX} at most")
    if plan.task is not Task.GOALS:
        morph_between(motion.start, plan.contour, motion.rotation_rad)
    elif not (is_contour(motion.start) and is_contour(plan.contour)):
        raise ShapeError("a motion between contours that cross themselves, run clockwise or enclose nothing")


def _with_track(plan: Plan, motion: Motion, roster: Roster, config: PartitionConfig) -> Plan:
    """Return a plan whose goals have found their way, from the first of them in its motion."""
    contours, obstacles = _content((motion.start, plan.contour)), _content(plan.obstacles)
    goals = motion.track[0].tobytes(), plan.goal_types.tobytes()
    try:
        places = _track(contours, motion.rotation_rad, goals, obstacles, roster, config, motion.knots)
    except ShapeError:
        raise
    except GEOMETRY_ERRORS as error:
        raise ShapeError(f"cannot be followed ({type(error).__name__}: {error}); simplify it") from error
    return replace(plan, goals=places[-1], motion=replace(motion, track=places))


@lru_cache(maxsize=4)  # the mission computer and all robots that share a process ask for the same
def _track(  # noqa: PLR0913, PLR0917 - all that the track follows from, by content
    contours: tuple[bytes, ...],
    rotation_rad: float,
    goals: tuple[bytes, bytes],
    obstacles: tuple[bytes, ...],
    roster: Roster,
    config: PartitionConfig,
    knots: int,
) -> FloatArray:
    start, target, *outlines = (np.frombuffer(points).reshape(-1, 2) for points in (*contours, *obstacles))
    begin = GoalSet(np.frombuffer(goals[0]).reshape(-1, 2), np.frombuffer(goals[1], dtype=np.int64))
    morph = morph_between(start, target, rotation_rad)
    places = track(morph, begin, roster, tuple(outlines), config, knots=knots)
    places.flags.writeable = False
    return places


def _content(polygons: tuple[FloatArray, ...]) -> tuple[bytes, ...]:
    return tuple(np.ascontiguousarray(polygon, dtype=np.float64).tobytes() for polygon in polygons)


def goals_crc(goals: FloatArray, types: IntArray) -> int:
    """Return the checksum of goals, in whole centimeters, and of their types; 0 for no goals."""
    if not len(goals):
        return 0
    centimeters = np.rint(goals * _CM_PER_M).astype("<i8")
    return zlib.crc32(types.astype("<i8").tobytes(), zlib.crc32(centimeters.tobytes()))
