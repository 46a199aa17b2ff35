"""From a path to a preferred velocity (spec 12.1, outer loop without avoidance)."""

from __future__ import annotations

import numpy as np

from swarm_agent.control.config import ControlConfig
from swarm_agent.planar import length_of
from swarm_agent.planning.path_planner import PathPlanner
from swarm_msgs_py.types import FloatArray

_NO_PATH = np.empty((0, 2))
_STAND = np.zeros(2)
_PARK_SIGMAS, _UNPARK_SIGMAS = 1.0, 4.0
"""Standard deviations of the estimate below which parking and starting again would only follow its noise."""


_AHEAD = 1.5
"""How far along the next leg of a path sensed points matter [m]."""

_REACHED = 0.05
"""A way-point this near is behind [m]."""

_JUMP = 2.0
"""A destination that is this many times farther from the last one than its drift explains is another one."""


class PathFollower:
    """Keeps the path to a destination up to date and says how fast to drive along it.

    Parameters
    ----------
    config : ControlConfig
    period_s : float
        Control period [s].
    radius : float
        Coverage radius of the robot [m].
    """

    def __init__(self, config: ControlConfig, period_s: float, radius: float) -> None:
        self._config = config
        self._radius = radius
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

    def step(  # noqa: PLR0913, PLR0917 - where the robot is, and where it is to be
        self,
        planner: PathPlanner,
        position: FloatArray,
        destination: FloatArray | None,
        sigma: float = 0.0,
        contacts: FloatArray = _NO_PATH,
        drift: FloatArray | None = None,
    ) -> FloatArray:
        """Return the velocity that follows the path, world frame, shape (2,) [m/s].

        To a destination that moves the robot adds its velocity to what makes up for the distance (spec 12.1, v_ff), and
        does not park unless it hardly moves.

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
        contacts : (n, 2) array
            Sensed surface points relative to the robot, axes of the world [m].
        drift : (2,) array or None
            Velocity of the destination [m/s]; None: it is at rest.
        """
        if drift is None or not self._carry(planner, destination, drift):
            self._retarget(planner, destination)
        if destination is None:
            return _STAND
        self._advance(planner, position, destination, contacts)
        if not len(self.path):
            return _STAND  # no way there: wait for the map or the assignment to change
        return self._velocity(position, sigma) if drift is None else self._pursuit(position, sigma, drift)

    def _retarget(self, planner: PathPlanner, destination: FloatArray | None) -> None:
        """Forget the path when the destination or the map is another one."""
        same = self._destination is destination or (
            self._destination is not None
            and destination is not None
            and self._destination.tolist() == destination.tolist()
        )
        if not same or planner is not self._planner:
            self._destination, self._planner = destination, planner
            self._parked = False
            self.path = _NO_PATH

    def _carry(self, planner: PathPlanner, destination: FloatArray | None, drift: FloatArray) -> bool:
        """Move the end of the path with a destination that drifts [m/s]; False if this is another destination."""
        if destination is None or self._destination is None or planner is not self._planner:
            return False
        step = float(np.hypot(*(destination - self._destination)))
        if step > _JUMP * float(np.hypot(*drift)) * self._period + _REACHED:
            return False
        self._destination = destination
        if len(self.path):
            self.path = np.concatenate((self.path[:-1], destination[None]))
            if len(self.path) > 1 and not planner.is_clear(self.path[-2], destination):
                self.path = _NO_PATH
        return True

    def _advance(
        self, planner: PathPlanner, position: FloatArray, destination: FloatArray, contacts: FloatArray
    ) -> None:
        """Drop way-points that are behind; plan anew when pushed off the path.

        On the map a corner may be behind that is still ahead: the map is certain, but the own place on it is not. What
        is sensed has no such error, so a way-point stays as long as something stands on the leg after it.
        """
        while len(self.path) > 1 and planner.is_clear(position, self.path[1]):
            is_reached = length_of(self.path[0] - position) < _REACHED
            if not is_reached and self._is_obstructed(self.path[1] - position, contacts):
                break
            self.path = self.path[1:]
        if not len(self.path) or not planner.is_clear(position, self.path[0]):
            path = planner.path(position, destination)
            self.path = _NO_PATH if path is None else path

    def _is_obstructed(self, leg: FloatArray, contacts: FloatArray) -> bool:
        """Return whether a sensed point stands in the way along a leg that starts here, (2,) [m]."""
        length = length_of(leg)
        if not len(contacts) or length == 0.0:
            return False
        direction = leg / length
        along = contacts @ direction
        nearest = np.minimum(along, min(length, _AHEAD))[:, None] * direction
        return bool(((along > 0.0) & (np.hypot(*(contacts - nearest).T) < self._radius)).any())

    def _velocity(self, position: FloatArray, sigma: float) -> FloatArray:
        offset = self.path[0] - position
        distance = length_of(offset)
        is_last = len(self.path) == 1
        config = self._config
        park = max(config.park_m, _PARK_SIGMAS * sigma)
        limit = max(config.unpark_m, _UNPARK_SIGMAS * sigma) if self._parked else park
        self._parked = is_last and distance < limit
        if self._parked or distance == 0.0:
            return _STAND
        return self._towards(offset, is_last=is_last)

    def _pursuit(self, position: FloatArray, sigma: float, drift: FloatArray) -> FloatArray:
        """Return the velocity of a robot whose destination moves with `drift` [m/s]."""
        if len(self.path) > 1:
            self._parked = False
            return self._towards(self.path[0] - position, is_last=False)
        if float(np.hypot(*drift)) < self._config.park_drift_m_s:
            return self._velocity(position, sigma)
        self._parked = False
        velocity: FloatArray = self._config.gain_1_s * (self.path[0] - position) + drift
        speed = float(np.hypot(*velocity))
        return velocity * min(1.0, self._config.speed_max_m_s / speed) if speed > 0.0 else velocity

    def _towards(self, offset: FloatArray, *, is_last: bool) -> FloatArray:
        """Return the velocity that covers a way [m], other than none."""
        distance = float(np.hypot(*offset))
        # A corner may be reached at full speed, but not overshot within the tick.
        gain = self._config.gain_1_s if is_last else 1.0 / self._period
        velocity: FloatArray = offset * min(gain, self._config.speed_max_m_s / distance)
        return velocity
