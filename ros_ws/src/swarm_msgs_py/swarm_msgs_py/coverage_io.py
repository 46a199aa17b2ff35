"""The step contract of the coverage family: what a robot in space is given each tick, and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from swarm_msgs_py.types import FloatArray, IntArray


class CoverageMode(IntEnum):
    """What a robot is doing."""

    GATHERING = 0  # on the tree to the leader: waits for its descendants, then visits its ancestors
    WAITING = 1  # at the leader, or wherever it has lost its place, free to take one
    TRAVELING = 2  # on the way to the place that it has taken
    HOLDING = 3  # at its place, with its sensor on


@dataclass(frozen=True, slots=True, eq=False)
class CoverageInputs:
    """All that one robot learns in one tick.

    Attributes
    ----------
    tick : int
    time : float
        Simulated time [s].
    ids : (k,) int array
        Robots that it senses: all within twice the link range in line of sight, ascending (assumption A1).
    offsets : (k, 3) array
        Where they are, relative to it, axes of the world [m].
    position : (3,) array or None
        Global position [m]; None for everybody but the leader (assumption A4).
    inbox : tuple of bytes
        Frames heard since the last tick, by ascending sender.
    """

    tick: int
    time: float
    ids: IntArray
    offsets: FloatArray
    position: FloatArray | None
    inbox: tuple[bytes, ...]


@dataclass(frozen=True, slots=True, eq=False)
class CoverageReport:
    """What a robot says of itself, for people and metrics; nothing in the swarm depends on it.

    Attributes
    ----------
    mode : CoverageMode
    position : (3,) array or None
        Where it believes to be [m].
    target : (3,) array or None
        Place that it has taken or holds [m].
    hops : int
        Hop number in the rendezvous tree; -1 while unknown.
    searches : int
        How often it has told its hop number in this rendezvous: once, in synchronous rounds (eq. (6)).
    places : int
        Places on its board.
    is_done : bool
        Whether it knows of no place that is still to be filled.
    is_leading : bool
        Whether it obeys the operator's orders.
    """

    mode: CoverageMode
    position: FloatArray | None
    target: FloatArray | None
    hops: int
    searches: int
    places: int
    is_done: bool
    is_leading: bool


@dataclass(frozen=True, slots=True, eq=False)
class CoverageOutputs:
    """What one robot does in one tick.

    Attributes
    ----------
    tick : int
    command : (3,) array
        Velocity [m/s]; a robot that is told to stand still is not shaken by process noise.
    outbox : tuple of bytes
        Frames for all robots with a link to it.
    report : CoverageReport
    """

    tick: int
    command: FloatArray
    outbox: tuple[bytes, ...]
    report: CoverageReport
