"""Sequence number and hop count of a route in one integer, so that "is better" is one vector subtraction.

A *label* is a 32-bit integer, ``sequence << 16 | (255 - hops) << 8``. Label a is better than label b, newer or equally
new and shorter, when the wrapped 32-bit difference a - b is positive: serial number arithmetic (RFC 1982) on the
sequence number and on the hop count at once. A broken route has 255 hops and so the worst label of its number.

Legal routes carry even numbers, broken ones odd numbers (spec section 5.2). What violates that is no row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.messages.radio import HOPS_INFINITE, RouteRows
from swarm_msgs_py.types import EVERYONE, IntArray

LabelArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]

HOP = 1 << 8
"""What one hop more takes from a label."""

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


@dataclass(frozen=True, slots=True, eq=False)
class Advert:
    """Route rows of one hello, as its receiver would take them over.

    Attributes
    ----------
    destinations : (n,) int array
    labels : (n,) label array
        With the hop to the sender already counted.
    breaks : bool
        Whether some of the rows are broken routes.
    """

    destinations: IntArray
    labels: LabelArray
    breaks: bool


def advert_of(rows: RouteRows, hop_limit: int) -> Advert:
    """Return the legal rows of a hello: even and within `hop_limit`, or odd and infinite; each destination once."""
    infinite = rows.hops == HOPS_INFINITE
    legal = (infinite == (rows.sequences & 1 == 1)) & (infinite | (rows.hops < hop_limit))
    legal &= rows.destinations != EVERYONE
    destinations, hops = rows.destinations[legal], np.where(infinite, HOPS_INFINITE, rows.hops + 1)[legal]
    labels = labels_of(rows.sequences[legal], hops)
    if len(set(destinations.tolist())) != len(destinations):  # no sender of ours does this; the first one counts
        first = np.sort(np.unique(destinations, return_index=True)[1])
        destinations, labels = destinations[first], labels[first]
    return Advert(destinations, labels, not bool(is_finite(labels).all()))
