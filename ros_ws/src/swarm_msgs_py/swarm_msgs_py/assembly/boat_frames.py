"""What boats say to each other while they assemble: who I am, where my group is, what it is about to do.

Layout of a frame body, little-endian, without padding::

    phase u8 | boat u16 | step u16 | node u16 | shift 2 i16 | move u8 | flags u8 | urgency u8 | seen cells: 2 i16 each
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

from swarm_msgs_py.assembly.faces import OFFSETS, Cell
from swarm_msgs_py.binary import Reader, packed
from swarm_msgs_py.errors import FrameError

_FIXED = struct.Struct("<B3H2h3B")
_CELL = struct.Struct("<2h")
_DOCKING = 0x01

URGENCY_MAX = 255
"""Highest urgency that a frame can tell."""


class Phase(IntEnum):
    """Rounds of a step: every boat tells what it sees, leaders tell what they want, leaders tell what they do."""

    LOOK = 0
    CLAIM = 1
    GO = 2


class Move(IntEnum):
    """What a group does in a step; the values above 0 are those of `Face`, plus one."""

    STAY = 0
    UP = 1
    DOWN = 2
    LEFT = 3
    RIGHT = 4

    @property
    def offset(self) -> Cell:
        """The step that it makes."""
        return OFFSETS[self - 1] if self else (0, 0)


@dataclass(frozen=True, slots=True)
class BoatFrame:
    """One boat's word in one phase of a step.

    Attributes
    ----------
    phase : Phase
    boat : int
        Who speaks; in `Phase.CLAIM` and `Phase.GO` the leader of its group.
    step : int
        Step of the assembly, modulo 2^16.
    node : int
        Node of the assembly tree that its group makes up.
    shift : Cell
        How far the group stands from its place in the structure.
    move : Move
        What the group wants, or is, to do.
    is_docking : bool
        It drives straight to its partner, with permission; all others give way.
    urgency : int
        Grows while the group is held up.
    seen : tuple of Cell
        Occupied cells that the boat perceives, in `Phase.LOOK`.
    """

    phase: Phase
    boat: int
    step: int
    node: int
    shift: Cell
    move: Move = Move.STAY
    is_docking: bool = False
    urgency: int = 0
    seen: tuple[Cell, ...] = ()


def is_boat_frame(data: bytes) -> bool:
    """Return whether a frame begins as those of boats that find their ways by themselves."""
    return data[:1] in {bytes([phase]) for phase in Phase}


def encode_boat_frame(frame: BoatFrame) -> bytes:
    """Return a frame as bytes.

    Raises
    ------
    FrameError
        If a number does not fit its place.
    """
    flags = _DOCKING * frame.is_docking
    head = packed(
        _FIXED,
        frame.phase,
        frame.boat,
        frame.step & 0xFFFF,
        frame.node,
        *frame.shift,
        frame.move,
        flags,
        min(frame.urgency, URGENCY_MAX),
    )
    return head + b"".join(packed(_CELL, *cell) for cell in frame.seen)


@lru_cache(maxsize=4096)
def decode_boat_frame(data: bytes) -> BoatFrame:
    """Return the frame that `data` stands for.

    Raises
    ------
    FrameError
        If `data` is not exactly one frame.
    """
    reader = Reader(data, 0, len(data))
    phase, boat, step, node, x, y, move, flags, urgency = reader.fields(_FIXED)
    if phase > max(Phase) or move > max(Move) or flags > _DOCKING or reader.left() % _CELL.size:
        raise FrameError("not a frame of an assembling boat")
    seen = tuple((cell[0], cell[1]) for cell in _CELL.iter_unpack(reader.rest()))
    return BoatFrame(Phase(phase), boat, step, node, (x, y), Move(move), bool(flags), urgency, seen)
