"""What boats that follow timed guideposts tell each other: how far I am, what I touch, when my group leaves.

Layout of a frame, little-endian, without padding::

    version u8 | boat u16 | epoch u16 | steps done u16 | departure tick u32 | contacts and flags u8
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.binary import Reader, packed
from swarm_msgs_py.errors import FrameError

_HALTED, _STUCK = 1 << len(Face), 2 << len(Face)
_FIXED = struct.Struct("<B3HIB")
PROGRESS_VERSION = 0x91
"""First byte of a progress frame; orders begin with another."""
NO_DEPARTURE = 0xFFFFFFFF
"""In place of a departure tick: not yet."""


@dataclass(frozen=True, slots=True)
class ProgressFrame:
    """One boat's word in one tick.

    Attributes
    ----------
    boat : int
    epoch : int
        Of the plan that it follows.
    steps_done : int
        Last step of the plan that it has reached.
    departure_tick : int
        When its group leaves for the next step, told by the leader; `NO_DEPARTURE` if that is open.
    contacts : frozenset of Face
        Sides of its cell, in the frame of the grid, whose foils are pressed.
    is_halted : bool
        It was told to stop, stands on a cell, and will not leave it.
    is_stuck : bool
        Its group has met its partner, and the foils do not say that they hold together.
    """

    boat: int
    epoch: int
    steps_done: int
    departure_tick: int = NO_DEPARTURE
    contacts: frozenset[Face] = frozenset()
    is_halted: bool = False
    is_stuck: bool = False


def is_progress_frame(data: bytes) -> bool:
    """Return whether a frame says that it is one of progress."""
    return data[:1] == bytes([PROGRESS_VERSION])


def encode_progress_frame(frame: ProgressFrame) -> bytes:
    """Return a frame as bytes.

    Raises
    ------
    FrameError
        If a number does not fit its place.
    """
    bits = sum(1 << face for face in frame.contacts) | _HALTED * frame.is_halted | _STUCK * frame.is_stuck
    return packed(_FIXED, PROGRESS_VERSION, frame.boat, frame.epoch, frame.steps_done, frame.departure_tick, bits)


def decode_progress_frame(data: bytes) -> ProgressFrame:
    """Return the frame that `data` stands for.

    Raises
    ------
    FrameError
        If `data` is not exactly one frame.
    """
    reader = Reader(data, 0, len(data))
    version, boat, epoch, steps_done, departure, bits = reader.fields(_FIXED)
    if version != PROGRESS_VERSION or reader.left() or bits >= 2 * _STUCK:
        raise FrameError("not a progress frame of an assembling boat")
    return ProgressFrame(
        boat,
        epoch,
        steps_done,
        departure,
        frozenset(face for face in Face if bits & (1 << face)),
        bool(bits & _HALTED),
        bool(bits & _STUCK),
    )
