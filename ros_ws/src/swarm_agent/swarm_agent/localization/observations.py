"""What a round of ranging says: distances to neighbors, joined with what those say of themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId

AGE_MAX = 8
"""Ticks after which a hello says too little of where its sender is now; also drops a sender with another clock."""

_POSITION, _VELOCITY = slice(0, 2), slice(2, 4)
_XX, _XY, _YY, _SHARED = 4, 5, 6, 7
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

    def only(self, which: BoolArray) -> RangeObservations:
        """Return some of the observations, for a mask of shape (m,)."""
        return RangeObservations(self.positions[which], self.covariances[which], self.shared[which], self.ranges[which])


def observe(
    scan: RangeScan, neighbors: Mapping[NodeId, Presence], tick: int, period: float
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
    """
    heard = [
        (presence, distance, age)
        for neighbor, distance in zip(scan.neighbors.tolist(), scan.ranges.tolist(), strict=True)
        if (presence := neighbors.get(neighbor)) is not None and (age := (tick - presence.tick) & 0xFFFF) <= AGE_MAX
    ]
    if not heard:
        return _NOTHING, _NOTHING
    rows = np.concatenate([presence.belief for presence, _, _ in heard]).reshape(len(heard), -1)
    distances = np.array([distance for _, distance, _ in heard])
    ages = np.array([age for _, _, age in heard]) * period
    is_beacon = np.array([presence.is_beacon for presence, _, _ in heard])
    seen = RangeObservations(
        rows[:, _POSITION] + rows[:, _VELOCITY] * ages[:, None], rows[:, _XX : _YY + 1], rows[:, _SHARED], distances
    )
    is_usable = np.isfinite(distances) & (np.maximum(rows[:, _XX], rows[:, _YY]) < _VARIANCE_UNKNOWN)
    return seen.only(is_beacon & is_usable), seen.only(~is_beacon & is_usable)


_VARIANCE_UNKNOWN = (0.99 * SIGMA_UNKNOWN) ** 2
_NOTHING = RangeObservations(np.empty((0, 2)), np.empty((0, 3)), np.empty(0), np.empty(0))
