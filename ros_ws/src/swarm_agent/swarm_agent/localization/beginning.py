"""The first belief of a robot that was not told where it stands, among robots that know their place, if not exactly.

Trilateration on neighbors would answer at once, but with three of them and 2 m of noise the answer is the mirror image
in one of five cases. So a robot begins with a belief as wide as the reach of its radio; the filter splits it into
hypotheses, and a few rounds of ranging tell which of them is right (see `hypotheses`). With one or two neighbors it
stays wide, and is true all the same: the robot knows that it is lost, goes home, and meets others on the way.
"""

from __future__ import annotations

import numpy as np

from swarm_agent.localization.observations import RangeObservations
from swarm_msgs_py.types import FloatArray

KNOWN_M = 1.0
"""Standard deviation of a position that is known well enough to begin from [m]."""


def begin_among(
    beacons: RangeObservations, others: RangeObservations, range_sigma: float
) -> tuple[FloatArray, FloatArray] | None:
    """Return a position (2,) [m] and its covariance (2, 2) [m^2] to begin with.

    The position is the center of all who know their place, the nearest ones counting most. From the nearest of them the
    robot is a range away, and that one from the center no more than the farthest.

    Parameters
    ----------
    beacons, others : RangeObservations
        To beacons, and to robots that are none.
    range_sigma : float
        Standard deviation of a range [m].

    Returns
    -------
    tuple or None
        None if nobody knows where it is.
    """
    others = others.only(_widest_variances(others) <= KNOWN_M**2)
    positions = np.concatenate([beacons.positions, others.positions])
    if not len(positions):
        return None
    squares = np.concatenate([beacons.ranges, others.ranges]) ** 2 + range_sigma**2
    weights = 1.0 / squares
    center = weights @ positions / weights.sum()
    apart = ((positions - center) ** 2).sum(axis=1)
    variance = 0.5 * float(squares.min()) + float(apart.max())
    if not np.isfinite(center.sum() + variance):
        return None
    return center, variance * np.eye(2)


def _widest_variances(seen: RangeObservations) -> FloatArray:
    """Return the largest variances of the positions in any direction, (m,) [m^2]."""
    xx, xy, yy = seen.covariances.T
    widest: FloatArray = 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)
    return widest
