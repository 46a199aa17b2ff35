"""From a path to a preferred velocity (spec 12.1, outer loop without avoidance)."""

from __future__ import annotations

import numpy as np

from swarm_agent.control.config import ControlConfig
from swarm_agent.planning.path_planner import PathPlanner
from swarm_msgs_py.types import FloatArray

_NO_PATH = np.empty((0, 2))
_STAND = np.zeros(2)
_PARK_SIGMAS, _UNPARK_SIGMAS = 1.0, 4.0
"""Standard deviations of the estimate below which parking and starting again would only follow its noise."""


class PathFollower:
    """Keeps the path to a destination up to date and says how fast to drive along it."""

    def __init__(self, config: ControlConfig, period_s: float) -> None:
        self._config = config
        self._period = period_s
        self._destination: FloatArray | None = None
        self._planner: PathPlanner | None = None
        self._parked = False
        self.path = _NO_PATH
        """Way-points still to come, shape (k, 2), destination last [m]."""

    @property
    def is_parked(self) -> bool:
        """Whether the robot rests at its destination."""
        return self._parked

    def step(
        self, planner: PathPlanner, position: FloatArray, destination: FloatArray | None, sigma: float = 0.0
    ) -> FloatArray:
        """Return the velocity that follows the path, world frame, shape (2,) [m/s].

        Parameters
        ----------
        planner : PathPlanner
            Of the robot's free space.
        position : (2,) array
            Own estimate [m].
        destination : (2,) array or None
            Where to go [m]; None: stand still.
        sigma : float
            Standard deviation of the estimate, per axis [m]; who knows less parks sooner and starts again later.
        """
        self._retarget(planner, destination)
        if destination is None:
            return _STAND
        self._advance(planner, position, destination)
        if not len(self.path):
            return _STAND  # no way there: wait for the map or the assignment to change
        return self._velocity(position, sigma)

    def _retarget(self, planner: PathPlanner, destination: FloatArray | None) -> None:
        """Forget the path when the destination or the map is another one."""
        same = self._destination is destination or (
            self._destination is not None
            and destination is not None
            and bool(np.array_equal(self._destination, destination))
        )
        if not same or planner is not self._planner:
            self._destination, self._planner = destination, planner
            self._parked = False
            self.path = _NO_PATH

    def _advance(self, planner: PathPlanner, position: FloatArray, destination: FloatArray) -> None:
        """Drop way-points that are behind; plan anew when pushed off the path."""
        while len(self.path) > 1 and planner.is_clear(position, self.path[1]):
            self.path = self.path[1:]
        if not len(self.path) or not planner.is_clear(position, self.path[0]):
            path = planner.path(position, destination)
            self.path = _NO_PATH if path is None else path

    def _velocity(self, position: FloatArray, sigma: float) -> FloatArray:
        offset = self.path[0] - position
        distance = float(np.hypot(*offset))
        is_last = len(self.path) == 1
        config = self._config
        park = max(config.park_m, _PARK_SIGMAS * sigma)
        limit = max(config.unpark_m, _UNPARK_SIGMAS * sigma) if self._parked else park
        self._parked = is_last and distance < limit
        if self._parked or distance == 0.0:
            return _STAND
        # A corner may be reached at full speed, but not overshot within the tick.
        gain = self._config.gain_1_s if is_last else 1.0 / self._period
        velocity: FloatArray = offset * min(gain, self._config.speed_max_m_s / distance)
        return velocity
