"""Routes and adverts, with number and hop count in one integer, so that "is better" is one vector subtraction.

A *label* is a 32-bit integer, ``sequence << 16 | (255 - hops) << 8``. Label a is better than label b, newer or equally
new and shorter, when the wrapped 32-bit difference a - b is positive: serial number arithmetic (RFC 1982) on the
sequence number and on the hop count at once. A broken route has 255 hops and so the worst label of its number.

Legal routes carry even numbers, broken ones odd numbers (spec section 5.2). What violates that is no row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.messages.radio import HOPS_INFINITE, RouteRows
from swarm_msgs_py.types import EVERYONE, IntArray, NodeId

LabelArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]

NUMBER = 1 << 16
"""What the next sequence number adds to a label."""

LONG_AGO = 0x4000 * NUMBER
"""Taken from a label, gives one that is older than anything still in circulation."""


def labels_of(sequences: IntArray, hops: IntArray) -> LabelArray:
    """Return labels; the cast wraps, which is what a serial number does."""
    return (sequences << 16 | (HOPS_INFINITE - hops) << 8).astype(np.int32)


def sequences_of(labels: LabelArray) -> IntArray:
    """Return the sequence numbers of labels."""
    return (labels.astype(np.int64) >> 16) & 0xFFFF


def hops_of(labels: LabelArray) -> IntArray:
    """Return the hop counts of labels."""
    return HOPS_INFINITE - ((labels.astype(np.int64) >> 8) & 0xFF)


def is_finite(labels: LabelArray) -> BoolArray:
    """Return which labels stand for a route that is not broken."""
    finite: BoolArray = (labels & 0xFF00) != 0
    return finite


def broken(labels: LabelArray) -> LabelArray:
    """Return the labels after a break: infinite, with the last known number plus one, unless that is odd already."""
    return (labels & np.int32(-NUMBER)) | np.int32(NUMBER)


@dataclass(frozen=True, slots=True)
class Route:
    """One row of a route table.

    Attributes
    ----------
    destination, next_hop : NodeId
        `next_hop` is -1 for a broken route.
    hops : int
        `HOPS_INFINITE` for a broken route.
    sequence : int
        Destination sequence number.
    """

    destination: NodeId
    next_hop: NodeId
    hops: int
    sequence: int


@dataclass(frozen=True, slots=True, eq=False)
class Advert:
    """Route rows of one hello, as its receivers would take them over.

    Attributes
    ----------
    source : NodeId
        Who advertises.
    rows : bytes
        Little-endian 64-bit integers, ``source << 48 | destination << 32 | label``, with the hop to the source counted.
        Joining fifty byte strings costs a tenth of concatenating fifty arrays.
    """

    source: NodeId
    rows: bytes


def advert_of(source: NodeId, rows: RouteRows) -> Advert:
    """Return the legal rows of a hello: even and finite, or odd and infinite; each destination once."""
    destinations, hops, sequences = rows.destinations, rows.hops, rows.sequences
    legal = (sequences & 1 == (hops == HOPS_INFINITE)) & (hops != HOPS_INFINITE - 1) & (destinations != EVERYONE)
    if not legal.all():
        destinations, hops, sequences = destinations[legal], hops[legal], sequences[legal]
    if len(set(destinations.tolist())) != len(destinations):  # no sender of ours does this; the first one counts
        first = np.sort(np.unique(destinations, return_index=True)[1])
        destinations, hops, sequences = destinations[first], hops[first], sequences[first]
    labels = labels_of(sequences, np.minimum(hops + 1, HOPS_INFINITE))
    packed = (int(source) << 16 | destinations) << 32 | labels.astype(np.int64) & 0xFFFFFFFF
    return Advert(source, packed.astype("<i8").tobytes())


def unpacked(adverts: Sequence[Advert]) -> tuple[IntArray, IntArray, LabelArray]:
    """Return the rows of several adverts as columns: source, destination, label."""
    rows = np.frombuffer(b"".join([advert.rows for advert in adverts]), dtype="<u2").reshape(-1, 4)
    labels = rows[:, :2].copy().view("<i4").reshape(-1)
    return rows[:, 3].astype(np.int64), rows[:, 2].astype(np.int64), labels
