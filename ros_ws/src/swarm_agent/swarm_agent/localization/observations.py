"""What a round of ranging says: distances to neighbors, joined with what those say of themselves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId

VAGUE_M = 5.0
"""A robot less certain than this says less about where it is than one range to it does [m]."""

_POSITION, _VELOCITY = slice(0, 2), slice(2, 4)
_XX, _YY, _SHARED = 4, 6, 7
_VARIANCES = slice(_XX, _YY + 1)
"""Columns of `Presence.belief`."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeObservations:
    """Ranges to m neighbors, in ascending order of their addresses.

    Attributes
    ----------
    positions : (m, 2) array
        Where they are now by their own account: their last word, moved on with their velocity [m].
    covariances : (m, 3) array
        Of those positions: xx, xy, yy [m^2].
    shared : (m,) array
        Share of that covariance which neighbors have in common, 0 to 1.
    ranges : (m,) array
        Measured distances [m].
    """

    positions: FloatArray
    covariances: FloatArray
    shared: FloatArray
    ranges: FloatArray

    def __len__(self) -> int:
        return len(self.ranges)

    def only(self, which: BoolArray | slice) -> RangeObservations:
        """Return some of the observations: those of a mask of shape (m,), or of a slice."""
        return RangeObservations(self.positions[which], self.covariances[which], self.shared[which], self.ranges[which])


def observe(
    scan: RangeScan, neighbors: Mapping[NodeId, Presence], tick: int, period: float, age_max: int
) -> tuple[RangeObservations, RangeObservations]:
    """Return the usable ranges of a scan, to beacons and to other robots.

    Beacons are told by their hellos (spec section 5.4), not by their routes. A neighbor that was not heard lately, does
    not know where it is, or gave a range that is no number, is left out.

    Parameters
    ----------
    scan : RangeScan
        Measured at `tick`.
    neighbors : mapping
        Latest presence of each radio neighbor.
    tick : int
    period : float
        Length of a tick [s].
    age_max : int
        Ticks after which a hello says too little of where its sender is now; also drops a sender with another clock.
    """
    beacons: list[tuple[FloatArray, float, float]] = []
    others: list[tuple[FloatArray, float, float]] = []
    for neighbor, distance in zip(scan.neighbors.tolist(), scan.ranges.tolist(), strict=True):
        presence = neighbors.get(neighbor)
        if presence is not None and (age := (tick - presence.tick) & 0xFFFF) <= age_max:
            (beacons if presence.is_beacon else others).append((presence.belief, distance, age * period))
    first = len(beacons)
    heard = beacons + others
    if not heard:
        return _NOTHING, _NOTHING
    beliefs, distances, ages = zip(*heard, strict=True)
    rows, ranges = np.concatenate(beliefs).reshape(len(heard), -1), np.array(distances)
    seen = RangeObservations(
        rows[:, _POSITION] + rows[:, _VELOCITY] * np.array(ages)[:, None], rows[:, _VARIANCES], rows[:, _SHARED], ranges
    )
    is_usable = np.isfinite(ranges) & (rows[:, _VARIANCES].max(axis=1) < _VARIANCE_UNKNOWN)
    if not is_usable.all():
        first = int(np.count_nonzero(is_usable[:first]))
        seen = seen.only(is_usable)
    return seen.only(slice(0, first)), seen.only(slice(first, None))


def bodies(neighbors: Iterable[Presence]) -> tuple[FloatArray, FloatArray]:
    """Return where neighbors that are robots say they are, (n, 2) [m], and with what standard deviation, (n,) [m]."""
    beliefs = [presence.belief for presence in neighbors if presence.robot_type]
    if not beliefs:
        return _NOTHING.positions, _NOTHING.ranges
    rows = np.concatenate(beliefs).reshape(len(beliefs), -1)
    return rows[:, _POSITION], np.sqrt(0.5 * (rows[:, _XX] + rows[:, _YY]))


def strangers(scan: RangeScan, neighbors: Mapping[NodeId, Presence]) -> FloatArray:
    """Return the ranges to robots that have hardly an idea where they are, (n,) [m]."""
    pairs = zip(scan.neighbors.tolist(), scan.ranges.tolist(), strict=True)
    heard = ((neighbors.get(neighbor), distance) for neighbor, distance in pairs)
    return np.array(
        [
            distance
            for presence, distance in heard
            if presence is not None and presence.robot_type and presence.sigma >= VAGUE_M and math.isfinite(distance)
        ]
    )


_VARIANCE_UNKNOWN = (0.99 * SIGMA_UNKNOWN) ** 2
_NOTHING = RangeObservations(np.empty((0, 2)), np.empty((0, 3)), np.empty(0), np.empty(0))
