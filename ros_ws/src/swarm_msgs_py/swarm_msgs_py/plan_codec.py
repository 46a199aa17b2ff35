"""Plans as bytes.

The places in a plan are ``uint16`` steps from the plan's least x and y; a step is a centimeter, in a plan more than
655 m wide the least power of two of centimeters that covers it. The plan is by far the longest body, and every radio
waits for it: this halves it. A plan whose goals the robots find for themselves, or that has none, says instead for whom
it is: 5 bytes per type of robot instead of 5 per goal. Only a plan whose shape moves tells its motion, behind all else
(`motion_codec`), and after that a plan that turns the robots tells where to: one bit of the task each says so.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, replace

import numpy as np

from swarm_msgs_py.binary import COORDINATE_MAX, Reader, checked, frozen, packed, packed_integers
from swarm_msgs_py.errors import ConfigError, FrameError
from swarm_msgs_py.messages.bodies import Motion, Plan, Task
from swarm_msgs_py.motion_codec import (
    check_corners,
    check_found,
    check_track,
    decode_head,
    decode_track,
    encode_head,
    encode_track,
)
from swarm_msgs_py.partition.config import Method
from swarm_msgs_py.roster import Roster, TypeGroup
from swarm_msgs_py.types import FloatArray, IntArray

_HEAD = struct.Struct("<IHHHBBii")  # epoch; contour, obstacles, bodies; task, log2 of the step [cm]; origin
_COUNT = struct.Struct("<H")
_GROUPS = struct.Struct("<B")
_GROUP = struct.Struct("<BHH")  # type, robots, radius [mm]
_PARTITION = struct.Struct("<BI")  # method, checksum of the goals
_CM_PER_M, _MM_PER_M = 100.0, 1000.0
_OFFSET_MAX = 0xFFFF  # steps from the origin of a plan
_DOUBLINGS_MAX = 16
_ROUNDING = 1e-6  # [mm]; what was decoded is encoded as the same number
_MOVES, _FACES = 0x80, 0x40  # bits of the task in plans with a motion, and with a heading
_HEADING = struct.Struct("<h")  # [1e-4 rad]
_HEADING_STEPS_PER_RAD = 1e4
_TASKS, _METHODS = tuple(Task), tuple(Method)  # they travel as their numbers in this order

ROBOTS_MAX = 1000
"""Robots that a plan on the air may be for: every robot holds a goal for each of them, or computes it."""

_NO_GOALS, _NO_TYPES = np.empty((0, 2)), np.empty(0, dtype=np.int64)
_NO_GOALS.flags.writeable = _NO_TYPES.flags.writeable = False


def encode_plan(plan: Plan) -> bytes:
    """Return the fields of a plan as bytes.

    Raises
    ------
    FrameError
        If a value does not fit the format, or something is missing that the task needs.
    """
    if len(plan.goal_types) != len(plan.goals):
        raise FrameError(f"{len(plan.goals)} goals with {len(plan.goal_types)} types")
    if plan.task is Task.GOALS:
        _check_goals(len(plan.goals))
    _check_bodies(plan.bodies, len(plan.obstacles))
    named = plan.goals if plan.task is Task.GOALS else _NO_GOALS
    groups = (plan.contour, *plan.obstacles, named, *_moving_places(plan))
    doublings, steps = _in_steps(checked(np.concatenate([np.reshape(group, (-1, 2)) for group in groups])))
    origin = steps.min(axis=0) if len(steps) else np.zeros(2, dtype=np.int64)
    contour, *others = np.split(steps - origin, np.cumsum([np.size(group) // 2 for group in groups])[:-1])
    obstacles, goals, moving = others[: len(plan.obstacles)], others[len(plan.obstacles)], others[-2:]
    task = _TASKS.index(plan.task) | (_MOVES if plan.motion is not None else 0)
    task |= _FACES if plan.heading is not None else 0
    head = packed(_HEAD, plan.epoch, len(contour), len(obstacles), plan.bodies, task, doublings, *origin.tolist())
    parts = [head, packed_integers(contour, "<u2")]
    for obstacle in obstacles:
        parts += [packed(_COUNT, len(obstacle)), packed_integers(obstacle, "<u2")]
    if plan.task is Task.GOALS:
        parts += [packed(_COUNT, len(goals)), packed_integers(goals, "<u2"), packed_integers(plan.goal_types, "<u1")]
    else:
        parts.append(_encode_roster(plan))
    if plan.task is Task.PARTITION:
        if plan.method is None:
            raise FrameError("a plan to partition a shape without the method")
        parts.append(packed(_PARTITION, _METHODS.index(plan.method), plan.goals_crc))
    if plan.motion is not None:
        parts.append(_encode_motion(plan, plan.motion, *moving))
    if plan.heading is not None:
        parts.append(_encode_heading(plan.heading))
    return b"".join(parts)


def decode_plan(reader: Reader) -> Plan:
    """Return the plan that comes next.

    Raises
    ------
    FrameError
        If it is none.
    """
    epoch, corners, obstacles, bodies, number, doublings, *origin = reader.fields(_HEAD)
    _check_bodies(bodies, obstacles)
    number, bits = number & ~(_MOVES | _FACES), number & (_MOVES | _FACES)
    if number >= len(_TASKS):
        raise FrameError(f"unknown task: {number}")
    if doublings > _DOUBLINGS_MAX:
        raise FrameError(f"a step of 2^{doublings} cm")
    grid = _Grid(np.array(origin), doublings)
    contour = grid.read_points(reader, corners)
    polygons = tuple(grid.read_points(reader, reader.fields(_COUNT)[0]) for _ in range(obstacles))
    task = _TASKS[number]
    goals, types, roster, method, crc = _NO_GOALS, _NO_TYPES, None, None, 0
    if task is Task.GOALS:
        (count,) = reader.fields(_COUNT)
        _check_goals(count)
        goals = grid.read_points(reader, count)
        types = _read_types(reader, count)
    else:
        roster = _decode_roster(reader)
    if task is Task.PARTITION:
        method_number, crc = reader.fields(_PARTITION)
        if method_number >= len(_METHODS):
            raise FrameError(f"unknown partition method: {method_number}")
        method = _METHODS[method_number]
    plan = Plan(epoch, contour, polygons, goals, types, bodies, task, roster, method, crc)
    if bits & _MOVES:
        plan = _decode_motion(reader, plan, grid)
    return replace(plan, heading=_decode_heading(reader)) if bits & _FACES else plan


def shortening(plan: Plan) -> str:
    """Return what makes a plan long, and what to do about it."""
    corners = sum(map(len, plan.obstacles))
    goals = f"{len(plan.goals)} goals of 5 bytes, " if plan.task is Task.GOALS else ""
    remedy = "use fewer goals, or simplify" if goals else "simplify"
    return (
        f"it has {goals}{len(plan.contour)} contour points of 4, and {len(plan.obstacles)} obstacles with {corners} "
        f"corners of 4: {remedy} the contour or the obstacles"
    )


def _moving_places(plan: Plan) -> tuple[FloatArray, FloatArray]:
    """Return the places that a motion adds to its plan: the first contour, and what is told of the goals.

    Raises
    ------
    FrameError
        If the track does not lead to the goals.
    """
    motion = plan.motion
    if motion is None:
        return _NO_GOALS, _NO_GOALS
    if not plan.task.has_goals:
        return motion.start, _NO_GOALS
    if plan.task is Task.PARTITION:
        if motion.track.shape[1:] != plan.goals.shape or not len(motion.track):
            raise FrameError("a motion without the goals that it begins with")
        return motion.start, motion.track[0]
    check_track(motion.track, plan.goals, motion.knots)
    return motion.start, motion.track


def _encode_motion(plan: Plan, motion: Motion, start: IntArray, places: IntArray) -> bytes:
    check_corners(len(plan.contour))
    if plan.task is Task.PARTITION:
        check_found(len(places), motion.knots)
    parts = [encode_head(motion, plan.follows), packed_integers(start, "<u2")]
    if plan.task is Task.GOALS:
        parts.append(encode_track(places.reshape(motion.track.shape)))
    elif plan.task is Task.PARTITION:
        parts += [packed_integers(places, "<u2"), packed_integers(plan.goal_types, "<u1")]
    return b"".join(parts)


def _decode_motion(reader: Reader, plan: Plan, grid: _Grid) -> Plan:
    check_corners(len(plan.contour))
    head = decode_head(reader)
    start = grid.read_points(reader, head.corners)
    goals, types, track = plan.goals, plan.goal_types, np.empty((0, 0, 2))
    if plan.task is Task.GOALS:
        track = grid.places(decode_track(reader, grid.steps(goals), head.knots))
    elif plan.roster is not None and plan.task is Task.PARTITION:
        check_found(plan.roster.size, head.knots)
        goals = grid.read_points(reader, plan.roster.size)
        types = _read_types(reader, plan.roster.size)
        if (np.sort(types) != np.sort(plan.roster.interleaved_types())).any():
            raise FrameError("a motion that begins with goals for other robots")
        track = frozen(goals[None].copy())
    motion = Motion(head.begins, head.ticks, start, head.rotation_rad, track, head.knots)
    return replace(plan, goals=goals, goal_types=types, motion=motion, follows=head.follows)


def _encode_heading(heading: float) -> bytes:
    if not abs(heading) <= math.pi:  # false for what is no number
        raise FrameError(f"a heading of {heading:g} rad")
    return packed(_HEADING, round(heading * _HEADING_STEPS_PER_RAD))


def _decode_heading(reader: Reader) -> float:
    heading = float(reader.fields(_HEADING)[0]) / _HEADING_STEPS_PER_RAD
    if abs(heading) > math.pi + 1.0 / _HEADING_STEPS_PER_RAD:
        raise FrameError(f"a heading of {heading:g} rad")
    return min(max(heading, -math.pi), math.pi)


@dataclass(frozen=True, slots=True)
class _Grid:
    """The steps of a plan, and the places that they stand for."""

    origin: IntArray
    doublings: int

    def places(self, steps: IntArray) -> FloatArray:
        """Return the places of (..., 2) steps from the origin [m]."""
        return frozen(checked((self.origin + steps) * 2**self.doublings / _CM_PER_M))

    def steps(self, places: FloatArray) -> IntArray:
        """Return the steps that stand for (..., 2) places."""
        steps: IntArray = np.rint(places * (_CM_PER_M / 2**self.doublings)).astype(np.int64) - self.origin
        return steps

    def read_points(self, reader: Reader, count: int) -> FloatArray:
        """Return the next (count, 2) points [m]."""
        return self.places(reader.array("<u2", 2 * count).astype(np.int64).reshape(count, 2))


def _read_types(reader: Reader, count: int) -> IntArray:
    return frozen(reader.array("<u1", count).astype(np.int64))


def _encode_roster(plan: Plan) -> bytes:
    """Return for whom a plan is; radii are rounded up to millimeters, so that nobody is larger than it says."""
    if plan.roster is None:
        raise FrameError(f"a plan to do '{plan.task.value}' without a roster")
    _check_size(plan.roster)
    groups = plan.roster.groups
    parts = [packed(_GROUPS, len(groups))]
    for group in groups:
        radius = math.ceil(group.coverage_radius_m * _MM_PER_M - _ROUNDING)
        parts.append(packed(_GROUP, group.type, group.count, radius))
    return b"".join(parts)


def _decode_roster(reader: Reader) -> Roster:
    (count,) = reader.fields(_GROUPS)
    rows = [reader.fields(_GROUP) for _ in range(count)]
    try:
        groups = (TypeGroup(type=t, count=n, coverage_radius_m=radius / _MM_PER_M) for t, n, radius in rows)
        roster = Roster(groups=tuple(groups))
    except ConfigError as error:
        raise FrameError(f"a roster that is none: {error}") from None
    _check_size(roster)
    return roster


def _check_size(roster: Roster) -> None:
    if roster.size > ROBOTS_MAX:
        raise FrameError(f"a roster of {roster.size} robots; the air carries at most {ROBOTS_MAX}")


def _check_goals(count: int) -> None:
    if count > ROBOTS_MAX:
        raise FrameError(f"{count} goals; the air carries at most {ROBOTS_MAX}: use fewer goals")


def _check_bodies(bodies: int, obstacles: int) -> None:
    if not 0 <= bodies <= obstacles:
        raise FrameError(f"{bodies} bodies among {obstacles} obstacles")


def _in_steps(points: FloatArray) -> tuple[int, IntArray]:
    """Return how often a centimeter is doubled to make a step, and points in steps; the same for points so rounded."""
    for doublings in range(_DOUBLINGS_MAX + 1):
        per_m = _CM_PER_M / 2**doublings
        limit = math.floor(COORDINATE_MAX * per_m)  # rounding must not lead beyond what may be decoded
        steps = np.clip(np.rint(points * per_m), -limit, limit).astype(np.int64)
        extent = int(np.ptp(steps, axis=0).max()) if len(steps) else 0
        if extent <= _OFFSET_MAX:
            break
    if doublings and 2 * extent <= _OFFSET_MAX:  # rounding has made it just narrow enough for steps half as long
        return doublings - 1, 2 * steps
    return doublings, steps
