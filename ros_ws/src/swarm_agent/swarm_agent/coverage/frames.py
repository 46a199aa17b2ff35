"""Frames of the coverage family: length-checked binary records, little-endian."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from hashlib import blake2b

import numpy as np

from swarm_msgs_py.binary import Reader, checked, packed
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.types import FloatArray, NodeId

VERSION = 1
_HEAD = struct.Struct("<BHBBIH")  # version, sender, mode, flags, digest, number of places
_TREE = struct.Struct("<HHHHH")  # term, hops, parent, size, met
_PLACE = struct.Struct("<HHHBHfff")  # author, number, version, state, holder, position
_MISSION = struct.Struct("<HHHIfffH")  # term, leader, order, tick and velocity of the flock, length of the shape
_HAS_TREE, _HAS_MISSION, _IS_HEARTBEAT = 1, 2, 4
_MODES = frozenset(map(int, CoverageMode))
NOBODY = NodeId(0xFFFF)
"""Stands for no robot: a parent that is not there, a place that nobody holds."""

Key = tuple[NodeId, int]
"""Name of a place: who offered it first, and its number among those."""


class State(IntEnum):
    """What became of a place; of two records of equal version, the higher state stands."""

    OPEN = 0
    WITHDRAWN = 1  # does not call back a robot that has set out in the meantime
    TAKEN = 2
    HELD = 3
    NEEDLESS = 4  # its robot has left it: the others cover the shape, and are linked, without it


_STATES = frozenset(map(int, State))


@dataclass(frozen=True, slots=True)
class Place:
    """One place of the layout, as all robots come to know it.

    Attributes
    ----------
    key : Key
    version : int
        Raised when a place becomes free again.
    state : State
    holder : NodeId
        Who has taken, holds or has left it; `NOBODY` otherwise.
    position : tuple of float
        Where it is, x, y, z [m]; once held, where the holder stands.
    """

    key: Key
    version: int
    state: State
    holder: NodeId
    position: tuple[float, float, float]

    @property
    def rank(self) -> tuple[int, State, int]:
        """Of two records of one place, the one of higher rank stands."""
        return self.version, self.state, self.holder


@dataclass(frozen=True, slots=True)
class TreeNews:
    """What a robot says of its place in the rendezvous tree.

    Attributes
    ----------
    term : int
        Which rendezvous.
    hops : int
        Links to the root.
    parent : NodeId
    size : int
        Robots in its subtree, itself included; 0 while unknown.
    met : NodeId
        Ancestor that it has just met, or `NOBODY`.
    """

    term: int
    hops: int
    parent: NodeId
    size: int
    met: NodeId


@dataclass(frozen=True, slots=True)
class Mission:
    """What the leader asks of all.

    Attributes
    ----------
    term : int
        A higher term replaces a lower one; odd terms gather, even ones expand.
    leader : NodeId
    shape : bytes
        Packed description of the solid; empty while gathering.
    since : int
        Tick from which the formation moves: late enough for all to have heard of it.
    velocity : tuple of float
        With which it moves [m/s].
    order : int
        Number of the last order that is obeyed with it: a new leader goes on from there.
    """

    term: int
    leader: NodeId
    shape: bytes
    since: int = 0
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    order: int = 0


@dataclass(frozen=True, slots=True)
class Frame:
    """One transmission.

    Attributes
    ----------
    sender : NodeId
    mode : CoverageMode
    digest : int
        Of the board that the sender holds, 32 bits.
    is_heartbeat : bool
        Whether the digest asks for comparison.
    places : tuple of Place
        News of the board.
    tree : TreeNews or None
    mission : Mission or None
    """

    sender: NodeId
    mode: CoverageMode
    digest: int
    is_heartbeat: bool
    places: tuple[Place, ...]
    tree: TreeNews | None
    mission: Mission | None


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame.

    Raises
    ------
    FrameError
        If a field does not fit.
    """
    flags = (_HAS_TREE if frame.tree else 0) | (_HAS_MISSION if frame.mission else 0)
    flags |= _IS_HEARTBEAT if frame.is_heartbeat else 0
    parts = [packed(_HEAD, VERSION, frame.sender, frame.mode, flags, frame.digest, len(frame.places))]
    if frame.tree:
        parts.append(packed(_TREE, *(getattr(frame.tree, name) for name in TreeNews.__slots__)))
    if frame.mission:
        told = frame.mission
        fields = (told.term, told.leader, told.order, told.since, *told.velocity, len(told.shape))
        parts += [packed(_MISSION, *fields), told.shape]
    parts += [place_bytes(place) for place in frame.places]
    return b"".join(parts)


def on_air(position: FloatArray) -> tuple[float, float, float]:
    """Return a position (3,) [m] as it comes out at the other end: rounded to ``float32``."""
    x, y, z = position.astype(np.float32).tolist()
    return x, y, z


@lru_cache(maxsize=4096)
def place_bytes(place: Place) -> bytes:
    """Return the bytes of one place."""
    return packed(_PLACE, *place.key, place.version, place.state, place.holder, *place.position)


@lru_cache(maxsize=1 << 16)
def fingerprint(place: Place) -> int:
    """Return 32 bits that stand for one place, and make up a board's digest by exclusive or.

    A checksum will not do: it is linear, so that two records which change in the same bits cancel each other.
    """
    return int.from_bytes(blake2b(place_bytes(place), digest_size=4).digest(), "little")


@lru_cache(maxsize=4096)
def decode(data: bytes) -> Frame:
    """Return the frame that `data` stands for; shared, read-only.

    Raises
    ------
    FrameError
        If `data` is not exactly one frame of this version.
    """
    reader = Reader(data)
    version, sender, mode, flags, digest, count = reader.fields(_HEAD)
    if version != VERSION or flags & ~(_HAS_TREE | _HAS_MISSION | _IS_HEARTBEAT):
        raise FrameError(f"a coverage frame of version {version} with flags {flags}")
    if mode not in _MODES:
        raise FrameError(f"unknown mode: {mode}")
    tree = TreeNews(*reader.fields(_TREE)) if flags & _HAS_TREE else None
    mission = None
    if flags & _HAS_MISSION:
        term, leader, order, since, x, y, z, size = reader.fields(_MISSION)
        checked(np.array([x, y, z]))
        mission = Mission(term, NodeId(leader), bytes(reader.array("u1", size)), since, (x, y, z), order)
    places = tuple(_decode_place(reader) for _ in range(count))
    reader.finish()
    heartbeat = bool(flags & _IS_HEARTBEAT)
    return Frame(NodeId(sender), CoverageMode(mode), digest, heartbeat, places, tree, mission)


def _decode_place(reader: Reader) -> Place:
    return _place_of(*reader.fields(_PLACE))


@lru_cache(maxsize=1 << 16)
def _place_of(  # noqa: PLR0913, PLR0917 - the fields of a record
    author: int, number: int, version: int, state: int, holder: int, x: float, y: float, z: float
) -> Place:
    """Return the record of these fields: the same object each time, which is quickly known again."""
    if state not in _STATES:
        raise FrameError(f"unknown state of a place: {state}")
    checked(np.array([x, y, z]))
    return Place((NodeId(author), number), version, State(state), NodeId(holder), (x, y, z))
