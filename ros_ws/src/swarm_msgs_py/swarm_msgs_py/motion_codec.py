"""The motion of a plan as bytes, behind the plan's own.

Places are in the steps of the plan. A track is told backward from the plan's goals, where it ends, as second
differences between knots: goals move smoothly, so these are small even where the goals are fast, and most fit a byte.
Goals that stay where they are cost a quarter of a byte. Being whole steps, differences add up exactly. Robots that
compute the track for themselves are told where it begins.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.binary import Reader, packed, packed_integers
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.geometry.correspondence import CORNERS_MAX
from swarm_msgs_py.messages.bodies import Motion
from swarm_msgs_py.partition.moving import FOUND_MAX, KNOTS_MAX
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

_HEAD = struct.Struct("<IIIdHB")  # epoch that is followed; beginning, ticks; rotation; contour points, knots
_TURNS_MAX = 100.0  # [rad]; more is no motion of a shape
_BYTE = np.iinfo(np.int8)
_KNOTS_MIN = 2


@dataclass(frozen=True, slots=True)
class MotionHead:
    """What comes before the places of a motion."""

    follows: int
    begins: int
    ticks: int
    rotation_rad: float
    corners: int
    knots: int


def encode_head(motion: Motion, follows: int) -> bytes:
    """Return what comes before the places.

    Raises
    ------
    FrameError
        If a field does not fit.
    """
    head = MotionHead(follows, motion.begins, motion.ticks, motion.rotation_rad, len(motion.start), motion.knots)
    _check(head)
    return packed(_HEAD, head.follows, head.begins, head.ticks, head.rotation_rad, head.corners, head.knots)


def decode_head(reader: Reader) -> MotionHead:
    """Return what comes next.

    Raises
    ------
    FrameError
        If it is no head of a motion.
    """
    head = MotionHead(*reader.fields(_HEAD))
    _check(head)
    return head


def encode_track(track: IntArray) -> bytes:
    """Return a (knots, n, 2) track without its last knot, which the receiver knows; in steps.

    Raises
    ------
    FrameError
        If goals jump farther than two bytes can tell.
    """
    backward = np.diff(track[::-1], axis=0, prepend=track[-1:])
    bends = np.diff(backward, axis=0).swapaxes(0, 1)  # (n, knots - 1, 2)
    moves, is_wide = (bends != 0).any(axis=(1, 2)), ((bends < _BYTE.min) | (bends > _BYTE.max)).any(axis=(1, 2))
    masks = np.packbits(np.concatenate([moves, is_wide]))
    return masks.tobytes() + packed_integers(bends[moves & ~is_wide], "<i1") + packed_integers(bends[is_wide], "<i2")


def decode_track(reader: Reader, goals: IntArray, knots: int) -> IntArray:
    """Return the (knots, n, 2) track that ends at (n, 2) goals, in steps.

    Raises
    ------
    FrameError
        If the record is too short.
    """
    count = len(goals)
    masks: BoolArray = np.unpackbits(reader.array("<u1", -(-2 * count // 8)), count=2 * count).astype(np.bool_)
    moves, is_wide = masks[:count], masks[count:]
    bends = np.zeros((count, knots - 1, 2), dtype=np.int64)
    for rows, dtype in ((moves & ~is_wide, "<i1"), (is_wide, "<i2")):
        told = int(rows.sum())
        bends[rows] = reader.array(dtype, told * (knots - 1) * 2).reshape(told, knots - 1, 2)
    track = np.empty((knots, count, 2), dtype=np.int64)
    track[-1] = goals
    track[-2::-1] = goals + bends.swapaxes(0, 1).cumsum(axis=0).cumsum(axis=0)
    return track


def check_track(track: FloatArray, goals: FloatArray, knots: int) -> None:
    """Check that a track leads to the goals of its plan.

    Raises
    ------
    FrameError
        If it does not.
    """
    if track.shape != (knots, *goals.shape) or (track[-1] != goals).any():
        raise FrameError(f"a track of shape {track.shape} that does not lead to the {len(goals)} goals of its plan")


def check_found(robots: int, knots: int) -> None:
    """Check that a track is not too long for robots to find it for themselves.

    Raises
    ------
    FrameError
        If it is.
    """
    if robots * knots > FOUND_MAX:
        raise FrameError(
            f"a motion of {robots} robots over {knots} knots; robots find {FOUND_MAX // robots} for so many: take less"
            " time, or let the mission computer find the goals"
        )


def check_corners(corners: int) -> None:
    """Check that a contour that moves has not too many corners: every robot finds out how it does so.

    Raises
    ------
    FrameError
        If it has.
    """
    if corners > CORNERS_MAX:
        raise FrameError(f"a contour of {corners} corners cannot move; simplify it to {CORNERS_MAX} at most")


def _check(head: MotionHead) -> None:
    if head.ticks < 1 or not _KNOTS_MIN <= head.knots <= KNOTS_MAX:
        raise FrameError(f"a motion of {head.ticks} ticks and {head.knots} knots")
    check_corners(head.corners)
    if not math.isfinite(head.rotation_rad) or abs(head.rotation_rad) > _TURNS_MAX:
        raise FrameError(f"a motion that turns by {head.rotation_rad:g} rad")
