"""Where in the shape a robot is wanted: in the middle of its share, and where there are too few robots for the room.

A robot's *share* is the part of the shape that is nearer to it than to any other robot that it hears. To go to the
middle of the share is the gradient descent of coverage control [1]_, which ends in a regular mesh. But it evens out a
density as slowly as heat spreads, and its pull on a long wave of the density is hardly to be felt. So a second term
compares, within reach, the mean place of the room with the mean place of the robots: where these differ, the robots
stand too dense on one side. It acts beyond a slack, because the two differ a little in a perfect mesh too.

References
----------
.. [1] J. Cortes, S. Martinez, T. Karatas, F. Bullo, "Coverage control for mobile sensing networks", IEEE Transactions
   on Robotics and Automation 20(2), 2004.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from swarm_agent.forces.config import SharingForceConfig
from swarm_msgs_py.types import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Claim:
    """What a robot may claim of the shape.

    Attributes
    ----------
    way : (2,) array
        From the robot to where it is wanted [m].
    area : float
        Of its share [m^2].
    """

    way: FloatArray
    area: float


class Shares:
    """A shape as points of a hexagonal lattice, which robots divide among themselves.

    Parameters
    ----------
    config : SharingForceConfig
    contour : (k, 2) array
        Shape, simple [m].
    """

    def __init__(self, config: SharingForceConfig, contour: FloatArray) -> None:
        self._config = config
        area = float(shapely.Polygon(contour).area)
        self._points = _lattice(contour, area, config.samples)
        self._point_area = area / max(self._points.shape[1], 1)
        self._reach = config.range * math.sqrt(area)

    def claim(self, position: FloatArray, others: FloatArray) -> Claim | None:
        """Return where a robot is wanted, and how large its share is.

        Parameters
        ----------
        position : (2,) array
            Of the robot [m].
        others : (m, 2) array
            Of the robots that it hears [m].

        Returns
        -------
        Claim or None
            None if the robot has no share within reach.
        """
        limit = self._reach * self._reach
        room = self._points - position[:, None]
        room_squares = room[0] * room[0] + room[1] * room[1]
        near = (room_squares < limit).nonzero()[0]
        room, room_squares = room.take(near, axis=1), room_squares.take(near)
        away = others - position
        squares = away[:, 0] * away[:, 0] + away[:, 1] * away[:, 1]
        near = (squares < 4.0 * limit).nonzero()[0]  # those beyond have no part in what is within reach
        away, squares = away.take(near, axis=0), squares.take(near)
        share = _nearer_than(away, squares, room)
        count = share.shape[1]
        if not count:
            return None
        middle: FloatArray = share.sum(axis=1) / count
        # Weights fall to zero at the end of the reach, so that nothing jumps when a robot comes into it.
        of_room, of_robots = 1.0 - room_squares / limit, np.maximum(1.0 - squares / limit, 0.0)
        spread = room @ of_room / of_room.sum() - of_robots @ away / (1.0 + of_robots.sum())
        area = count * self._point_area
        return Claim(middle + self._beyond_slack(spread, area), area)

    def _beyond_slack(self, spread: FloatArray, area: float) -> FloatArray:
        """Return the way from the mean of the robots to that of the room, less what an even mesh may have of it."""
        length = float(np.hypot(spread[0], spread[1]))
        rest = max(length - self._config.spread_slack * math.sqrt(area), 0.0)
        return spread * (self._config.spread_gain * rest / max(length, _TINY))


_TINY = 1e-12  # [m]
_SCREEN = 6  # nearest robots, which take nearly all of the room: a cell of a regular mesh has six neighbors


def _nearer_than(away: FloatArray, squares: FloatArray, room: FloatArray) -> FloatArray:
    """Return the points that are nearer to a robot than to any other, (2, p), all as the robot sees them.

    Parameters
    ----------
    away : (m, 2) array
        Other robots [m].
    squares : (m,) array
        Their squared distances [m^2].
    room : (2, s) array
        Points [m].
    """
    for these in (squares.argsort()[:_SCREEN], slice(None)):  # few for many points, then all for the few that are left
        # A point q is nearer to another robot at d if q . d > d . d / 2.
        taken: BoolArray = np.logical_or.reduce(away[these] @ room > 0.5 * squares[these, None], axis=0)
        room = room.take((~taken).nonzero()[0], axis=1)
    return room


def _lattice(contour: FloatArray, area: float, count: int) -> FloatArray:
    """Return about `count` points of a hexagonal lattice that lie inside the contour, (2, s)."""
    pitch = math.sqrt(2.0 * area / (math.sqrt(3.0) * count))
    low, high = contour.min(axis=0), contour.max(axis=0)
    # Half a cell from the sides, so that the points of a box have its center.
    columns = np.arange(low[0] + 0.25 * pitch, high[0] + pitch, pitch)
    rise = 0.5 * math.sqrt(3.0) * pitch
    rows = np.arange(low[1] + 0.5 * rise, high[1], rise)
    x, y = np.meshgrid(columns, rows)
    x[1::2] -= 0.5 * pitch
    inside = shapely.contains_xy(shapely.Polygon(contour), x, y)
    return np.stack([x[inside], y[inside]])
