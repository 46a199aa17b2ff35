"""Collision avoidance from short-range proximity: safe by construction, live by choice of side.

*Safety.* Between two robots lies a free gap. Each may use up half of it within one tick, less a margin, whatever the
other does; so no two coverage circles can meet, with no communication and no knowledge of the other's size or velocity.
This is the buffered Voronoi cell of Zhou et al. (2017), widened to the servo's coasting: the displacement of a tick is
``v period + v_now delay`` where `delay` is the time that the velocity loop still runs on the old setpoint.

*Liveness.* Inside those half-planes the robot takes the direction that makes the most progress without heading for what
it would drive into within a few seconds, given how that has moved of late; ties go to the right-hand side, so that two
robots that meet head-on pass each other. The longer a robot makes no progress, the more it leans to that side, which
turns a jam into a roundabout; one that cannot move at all tries the other side.

References
----------
D. Zhou, Z. Wang, S. Bandyopadhyay, M. Schwager, "Fast, on-line collision avoidance for dynamic vehicles using buffered
Voronoi cells", IEEE Robotics and Automation Letters 2(2), 2017.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_agent.control.config import AvoidanceConfig
from swarm_agent.planar import length_of
from swarm_msgs_py.types import FloatArray

_SHARE = 0.5  # of the free gap that one of two robots may use up
_HEADINGS = np.linspace(-np.pi, np.pi, 48, endpoint=False)
_COS, _SIN = np.cos(_HEADINGS), np.sin(_HEADINGS)
_HIT_WEIGHT = 0.9  # of driving towards something, against progress 1.0
_SIDE_WEIGHT = 0.1  # of the preferred side: only decides between nearly equal ways
_IMPATIENCE = 0.2  # by which that weight grows per second without progress
_VIOLATION_WEIGHT = 100.0  # of each m/s beyond a safety limit: nothing outweighs safety
_STANDSTILL = 1e-9
_SLOW_SHARE = 0.2  # of the wanted speed: progress below it counts as none


@dataclass(frozen=True, slots=True, eq=False)
class _Surroundings:
    """What is near, one row per contact."""

    normals: FloatArray  # (n, 2) unit vectors towards the contacts
    limits: FloatArray  # (n,) largest safe velocity along each normal [m/s]
    centers: FloatArray  # (n, 2) of the discs behind the surface that are not to be driven into [m]


class Avoidance:
    """Turns the velocity that a robot wants into one that is safe.

    Parameters
    ----------
    config : AvoidanceConfig
    radius : float
        The robot's own coverage radius [m].
    period_s : float
        Control period [s].
    """

    def __init__(self, config: AvoidanceConfig, radius: float, period_s: float) -> None:
        self._config = config
        self._radius = radius
        self._period = period_s
        self._keep_out = radius + config.body_radius_m + config.passing_gap_m  # from those centers [m]
        self._side = 1.0  # +1: pass on the right
        self._patience_lost = 0.0  # seconds without progress, forgotten as progress comes back
        self._halted = 0.0  # seconds without motion
        self._is_blocked = False
        self._got_on = 0.0  # seconds of progress since it was last without patience
        self._seen = np.empty((0, 2))  # contacts of the last tick
        self._driven = np.zeros(2), np.zeros(2)  # what was chosen then, and the velocity that the robot had

    @property
    def is_blocked(self) -> bool:
        """Whether the robot has hardly got on for `stuck_after_s`, and not got on for `insist_s` without a break since.

        Where others make way for it, its first step must not be taken for the last: they would close the gap again.
        """
        return self._is_blocked

    def step(self, wanted: FloatArray, velocity: FloatArray, contacts: FloatArray, reach: float) -> FloatArray:
        """Return a safe velocity close to the wanted one.

        Parameters
        ----------
        wanted : (2,) array
            Preferred velocity [m/s].
        velocity : (2,) array
            Present velocity [m/s].
        contacts : (n, 2) array
            Nearest surface points of what is around, relative to the robot's center [m].
        reach : float
            Distance to where the robot wants to be next [m]; what lies beyond does not matter.

        Returns
        -------
        (2,) array
            Velocity setpoint [m/s]; all vectors are in one non-rotating frame.
        """
        chosen = wanted
        if not len(contacts):
            self._give_up()
        elif length_of(wanted) < _STANDSTILL:
            self._give_up()  # who wants nothing is not blocked
            if not self._is_far_from(contacts, velocity):
                chosen = _back_out(self._look(contacts, velocity), wanted, self._config.escape_speed_m_s)
        else:
            around = self._look(contacts, velocity)
            moving = self._track(contacts)
            if self._is_free(wanted, around, moving, reach):
                self._patience_lost = self._halted = 0.0
                self._insist(gets_on=True)
            else:
                chosen = self._choose(wanted, around, moving, reach)
                self._watch_progress(wanted, chosen)
        self._seen = contacts
        self._driven = chosen, velocity
        return chosen

    def _is_far_from(self, contacts: FloatArray, velocity: FloatArray) -> bool:
        """Return whether no limit can be near zero: a quick answer for robots at rest, which in the end all are."""
        nearest = min(abs(complex(x, y)) for x, y in contacts.tolist())
        coasting = length_of(velocity) * self._config.servo_delay_s
        return _SHARE * (nearest - self._radius) - self._config.margin_m - coasting > _STANDSTILL

    def _look(self, contacts: FloatArray, velocity: FloatArray) -> _Surroundings:
        """Return the safety limits and velocities of what is near."""
        distances = np.hypot(contacts[:, 0], contacts[:, 1])
        normals = contacts / np.maximum(distances, _STANDSTILL)[:, None]
        coasting = np.maximum(normals.dot(velocity), 0.0) * self._config.servo_delay_s
        limits = (_SHARE * (distances - self._radius) - self._config.margin_m - coasting) / self._period
        return _Surroundings(normals, limits, contacts + normals * self._config.body_radius_m)

    def _track(self, contacts: FloatArray) -> FloatArray:
        """Return how each contact has moved over ground since the last tick, zero for a new one, shape (n, 2) [m/s]."""
        if not len(self._seen):
            return np.zeros_like(contacts)
        chosen, velocity = self._driven
        moved = chosen * self._period + (velocity - chosen) * self._config.servo_delay_s
        steps = contacts[:, None] + moved - self._seen[None]
        squares = _squares(steps)
        rows, nearest = np.arange(len(contacts)), squares.argmin(axis=1)
        step, is_same = steps[rows, nearest], squares[rows, nearest] < self._config.track_m**2
        velocities: FloatArray = np.where(is_same[:, None], step / self._period, 0.0)
        return velocities

    def _is_free(self, wanted: FloatArray, around: _Surroundings, moving: FloatArray, reach: float) -> bool:
        if not (around.normals.dot(wanted) <= around.limits).all():
            return False
        return self._passes(wanted, around, moving) or not self._hits(wanted[None], around, moving, reach).any()

    def _passes(self, wanted: FloatArray, around: _Surroundings, moving: FloatArray) -> bool:
        """Return whether a velocity leads past everything, however far ahead: mostly so, and quicker than `_hits`."""
        (east, north), keep_out2 = wanted.tolist(), self._keep_out**2
        for (x, y), (its_east, its_north) in zip(around.centers.tolist(), moving.tolist(), strict=True):
            u, v = east - its_east, north - its_north
            along = u * x + v * y
            if along > 0.0 and along * along > max(u * u + v * v, _STANDSTILL) * (x * x + y * y - keep_out2):
                return False
        return True

    def _hits(self, velocities: FloatArray, around: _Surroundings, moving: FloatArray, reach: float) -> FloatArray:
        """Return how soon each velocity runs into something: 1 at once, 0 not within the horizon; shape (h,)."""
        centers, keep_out = around.centers, self._keep_out
        relative = velocities[:, None] - moving[None]
        along = relative[..., 0] * centers[:, 0] + relative[..., 1] * centers[:, 1]
        square = np.maximum(_squares(relative), _STANDSTILL)
        apart = _squares(centers)
        depth = along**2 - square * (apart - keep_out**2)
        hit_time = (along - np.sqrt(np.maximum(depth, 0.0))) / square
        speed = np.hypot(velocities[:, 0], velocities[:, 1])[:, None]
        matters = hit_time * speed < reach
        ahead = (along > 0.0) & (depth > 0.0) & (hit_time < self._config.horizon_s) & matters
        urgency = 1.0 - hit_time / self._config.horizon_s
        # Inside a keep-out disc only the part that leads deeper counts, so that sliding past stays possible.
        deeper = along / np.sqrt(square * np.maximum(apart, _STANDSTILL))
        urgency = np.where(apart < keep_out**2, deeper, urgency)
        worst: FloatArray = np.where(ahead, np.clip(urgency, 0.0, 1.0), 0.0).max(axis=1)
        return worst

    def _choose(self, wanted: FloatArray, around: _Surroundings, moving: FloatArray, reach: float) -> FloatArray:
        """Return the best of a fan of headings, each as fast as is safe."""
        speed = length_of(wanted)
        forward = wanted / speed
        left = np.array([-forward[1], forward[0]])
        headings = _COS[:, None] * forward + _SIN[:, None] * left
        closing = headings @ around.normals.T * speed
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = np.where(closing > 0.0, np.maximum(around.limits, 0.0) / closing, 1.0)
        paces = np.minimum(scale.min(axis=1), 1.0)
        velocities = np.vstack([headings * (speed * paces)[:, None], np.zeros((1, 2))])
        violation = np.maximum((velocities @ around.normals.T - around.limits).max(axis=1), 0.0)
        cost = _VIOLATION_WEIGHT * np.where(violation > _STANDSTILL, violation, 0.0)
        cost -= velocities @ forward / speed
        cost[:-1] += _HIT_WEIGHT * self._hits(headings * speed, around, moving, reach) * paces
        lean = _SIDE_WEIGHT + _IMPATIENCE * self._patience_lost
        cost[:-1] += lean * self._side * _SIN * paces
        chosen: FloatArray = velocities[int(np.argmin(cost))]
        return chosen

    def _watch_progress(self, wanted: FloatArray, chosen: FloatArray) -> None:
        """Lose patience without progress; change the preferred side after too long without motion."""
        speed = length_of(wanted)
        slow = _SLOW_SHARE * speed
        gets_on = float(wanted @ chosen) >= slow * speed
        lost = -self._period if gets_on else self._period
        self._patience_lost = min(max(self._patience_lost + lost, 0.0), self._config.stuck_after_s)
        self._insist(gets_on=gets_on)
        self._halted = self._halted + self._period if length_of(chosen) < slow else 0.0
        if self._halted >= self._config.stuck_after_s:
            self._side = -self._side
            self._halted = 0.0

    def _insist(self, *, gets_on: bool) -> None:
        """Call the robot blocked when its patience is lost, and from then on until it has got on for long enough."""
        if self._patience_lost >= self._config.stuck_after_s:
            self._is_blocked, self._got_on = True, 0.0
        elif self._is_blocked:
            self._got_on = self._got_on + self._period if gets_on else 0.0
            self._is_blocked = self._got_on < self._config.insist_s

    def _give_up(self) -> None:
        """Forget what was in the way."""
        self._patience_lost = self._halted = self._got_on = 0.0
        self._is_blocked = False


def _back_out(around: _Surroundings, wanted: FloatArray, speed_max: float) -> FloatArray:
    """Return the velocity of a robot that wants to rest, out of the margins that it stands in, if any."""
    if around.limits.min() >= 0.0:
        return wanted
    away = (around.normals * np.minimum(around.limits, 0.0)[:, None]).sum(axis=0)
    velocity: FloatArray = away * min(1.0, speed_max / max(length_of(away), _STANDSTILL))
    return velocity


def _squares(vectors: FloatArray) -> FloatArray:
    """Return the squared lengths of vectors (..., 2)."""
    x, y = vectors[..., 0], vectors[..., 1]
    squares: FloatArray = x * x + y * y
    return squares
