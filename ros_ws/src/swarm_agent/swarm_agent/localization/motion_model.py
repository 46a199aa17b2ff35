"""How a robot moves between two ticks, as its filter sees it: measured acceleration, integrated twice.

The state is [X, Xdot, Y, Ydot, bx, by]: that of the thesis, eq. (3.28), and the bias of the accelerometer in the body
frame. The bias is a constant that nobody knows; its variance is not a noise. Added to Q it would be far too small
after a minute (errors of a constant add up, those of a noise partly cancel) and too large in the first second. As a
state its effect is exact, and fixes reveal it, so that a robot that loses its fixes later drifts less.

The axes are not filtered apart, although they would be independent here: ranges to beacons correlate them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_agent.localization.kalman import Gaussian
from swarm_msgs_py.types import FloatArray

STATES = 6
POSITION = slice(0, 4, 2)
VELOCITY = slice(1, 4, 2)
BIAS = slice(4, 6)
OBSERVE_POSITION: FloatArray = np.eye(STATES)[POSITION].copy()
"""H of a position fix, (2, 6)."""
OBSERVE_VELOCITY: FloatArray = np.eye(STATES)[VELOCITY].copy()
"""H of a robot that knows its velocity, because it knows what it told its servo, (2, 6)."""


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One step of the model, as `kalman.predict` takes it: F (6, 6), B u (6,), Q (6, 6)."""

    transition: FloatArray
    drive: FloatArray
    noise: FloatArray


class MotionModel:
    """Twice integrated acceleration with noise and constant bias.

    A mean acceleration says by how much the velocity has changed, not when. A robot knows when: its setpoint changes at
    the start of a period, and its velocity follows a servo delay later. So a change of velocity counts for the position
    from then on, ``dx = v dt + dv (dt - delay)``; a delay of half the period gives the B of the thesis, eq. (3.29).

    Parameters
    ----------
    period : float
        Between two steps [s].
    acceleration_sigma : float
        Standard deviation of a measured mean acceleration, per axis [m/s^2].
    yaw_sigma : float
        Standard deviation of the heading that turns it into the world frame [rad].
    push_delay : float or None
        When in a period the velocity changes [s]; None for half of the period.
    push_delay_sigma : float
        How far it may deviate from that [s].
    """

    def __init__(
        self,
        period: float,
        acceleration_sigma: float,
        yaw_sigma: float,
        push_delay: float | None = None,
        push_delay_sigma: float = 0.0,
    ) -> None:
        self._period = period
        self._variance, self._yaw_variance = acceleration_sigma**2, yaw_sigma**2
        self._timing_variance = (period * push_delay_sigma) ** 2  # of the position, per (m/s^2)^2
        delay = period / 2.0 if push_delay is None else min(push_delay, period / 2.0)
        axis = np.array([period * (period - delay), period])
        coast = np.eye(STATES)
        coast[0, 1] = coast[2, 3] = period
        self._coast = coast
        # What a body acceleration adds to the state, B R(yaw), is linear in the cosine and the sine of the yaw.
        turns = np.zeros((STATES, 2, 2))
        turns[0:2, 0, 0] = turns[2:4, 1, 0] = turns[2:4, 0, 1] = axis
        turns[0:2, 1, 1] = -axis
        self._turns = turns.reshape(-1, 2)
        # B B^T. The noise of one mean acceleration moves position and velocity together; the diagonal Q of thesis
        # eq. (3.43) denies that, and its units do not fit (erratum E10).
        self._unit_noise = np.zeros((STATES, STATES))
        self._unit_noise[0:2, 0:2] = self._unit_noise[2:4, 2:4] = np.outer(axis, axis)

    def step(self, acceleration_body: FloatArray, yaw: float) -> Step:
        """Return the step over one period.

        Parameters
        ----------
        acceleration_body : (2,) array
            Measured *mean* over the period, body frame [m/s^2]; a point sample misses transients (erratum E12).
        yaw : float
            Heading that belongs to the body frame of the measurement [rad].
        """
        push = self._turns.dot((math.cos(yaw), math.sin(yaw))).reshape(STATES, 2)
        transition = self._coast.copy()
        np.subtract(self._coast[:, BIAS], push, out=transition[:, BIAS])
        forward, left = acceleration_body.tolist()
        # A wrong heading turns the acceleration sideways by |a| times the error; counted on both axes, to be safe.
        square = forward * forward + left * left
        noise = (self._variance + self._yaw_variance * square) * self._unit_noise
        noise[0, 0] += self._timing_variance * square
        noise[2, 2] += self._timing_variance * square
        return Step(transition, push.dot(acceleration_body), noise)

    def gap(self, periods: int, speed_sigma: float) -> Step:
        """Return the step over periods of which nothing is known.

        Parameters
        ----------
        periods : int
        speed_sigma : float
            Standard deviation of the change of velocity in the meantime, per axis [m/s]. It may have happened at once,
            so all of it counts for the position from the beginning.
        """
        duration = periods * self._period
        transition = np.eye(STATES)
        transition[0, 1] = transition[2, 3] = duration
        axis = speed_sigma * np.array([duration, 1.0])
        noise = np.zeros((STATES, STATES))
        noise[0:2, 0:2] = noise[2:4, 2:4] = np.outer(axis, axis)
        return Step(transition, np.zeros(STATES), noise)


def belief_at(position: FloatArray, covariance: FloatArray, speed_sigma: float, bias_max: float) -> Gaussian:
    """Return the belief of a robot whose position was just measured, and of whose motion nothing is known.

    Parameters
    ----------
    position : (2,) array
        Measured [m].
    covariance : (2, 2) array
        Of the measurement [m^2].
    speed_sigma : float
        Standard deviation per axis of the velocity [m/s], whose mean is zero.
    bias_max : float
        Bound of the accelerometer's bias, per axis [m/s^2]; the bias is uniform within, so its variance is a third of
        the square.
    """
    mean = np.zeros(STATES)
    mean[POSITION] = position
    variances = np.zeros(STATES)
    variances[VELOCITY], variances[BIAS] = speed_sigma**2, bias_max**2 / 3.0
    belief = np.diag(variances)
    belief[POSITION, POSITION] = covariance
    return Gaussian(mean, belief)


def restarted(belief: Gaussian, speed_sigma: float, position: FloatArray, covariance: FloatArray) -> Gaussian:
    """Return the belief of a robot that turned out to be elsewhere.

    What it knows of its accelerometer it still knows, and it moves on as before, give or take `speed_sigma`.

    Parameters
    ----------
    belief : Gaussian
    speed_sigma : float
        Standard deviation per axis of what the velocity may be off besides [m/s].
    position, covariance : (2,) and (2, 2) array
        Of the new position [m], [m^2].
    """
    mean, wider = belief.mean.copy(), belief.covariance.copy()
    mean[POSITION] = position
    wider[POSITION], wider[:, POSITION] = (
        0.0,
        0.0,
    )  # the old position's error is gone, and with it what it went along with
    wider[POSITION, POSITION] = covariance
    wider[VELOCITY, VELOCITY] += speed_sigma**2 * np.eye(2)
    return Gaussian(mean, wider)
