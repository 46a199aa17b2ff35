"""Sliding along a wall that ought not to be there.

On its map a robot plans paths that keep clear of all walls. If its path leads into one all the same, its estimate is
off, mostly along the wall: across it, the wall itself corrects the estimate. Then the way on is along the wall, in the
sense in which the path leads, until the wall's end shows up, which is a landmark. Without memory the robot would turn
back as soon as the point that it means to reach seems to lie behind it, and shuttle in front of the wall for good.
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import FloatArray

_STILL = 1e-9


class WallFollowing:
    """Bends a wanted velocity along the wall that it leads into.

    Parameters
    ----------
    radius : float
        Coverage radius of the robot [m].
    margin : float
        Gap to the wall that is kept [m].
    period_s : float
        Control period [s].
    """

    def __init__(self, radius: float, margin: float, period_s: float) -> None:
        self._clear = radius + margin
        self._period = period_s
        self._heading: FloatArray | None = None  # along the wall, while one is followed

    def step(self, wanted: FloatArray, walls: FloatArray) -> FloatArray:
        """Return the velocity to try instead, shape (2,) [m/s].

        Parameters
        ----------
        wanted : (2,) array
            Velocity that follows the path [m/s].
        walls : (n, 2) array
            Nearest points of walls that are on the map, relative to the robot, axes of the world [m].
        """
        speed = float(np.hypot(*wanted))
        if not len(walls) or speed < _STILL:
            self._heading = None
            return wanted
        distances = np.maximum(np.hypot(*walls.T), _STILL)
        inward = walls / distances[:, None]
        excess = inward @ wanted * self._period - (distances - self._clear)
        nearest = int(excess.argmax())
        if excess[nearest] <= 0.0 or inward[nearest] @ wanted <= 0.0:
            self._heading = None
            return wanted
        along = np.array([-inward[nearest, 1], inward[nearest, 0]])
        leading = wanted if self._heading is None else self._heading
        self._heading = along if along @ leading >= 0.0 else -along
        return self._heading * speed
