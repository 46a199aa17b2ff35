"""The velocity servo and the heading servo, vectorized over robots, at the physics rate.

Both are sampled: one call per physics step, the result held until the next (spec section 12.2, erratum E23).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, IntArray
from swarm_sim.firmware.servo_gains import ServoGains

HEADING_FREQUENCY = 11.9
"""Natural frequency of the heading loop [rad/s], that of the recommended velocity loop."""
HEADING_DAMPING = 0.707
HEADING_ACCELERATION_MAX = 60.0
"""Largest angular acceleration [rad/s^2]: half of what the drive force can do at the rim of the smallest type."""
HEADING_ERROR_MAX = 0.5
"""Largest heading error that is acted on [rad], and how far a turn's reference may run ahead (anti-windup)."""
HEADING_TOLERANCE = 2e-3
"""Heading error [rad] that a robot with no turn commanded lets be; a tenth of a degree."""

_STIFFNESS, _DAMPING = HEADING_FREQUENCY**2, 2.0 * HEADING_DAMPING * HEADING_FREQUENCY


class VelocityServo:
    """Planar LQR velocity servo with integral action and anti-windup.

    Parameters
    ----------
    gains : ServoGains
        One entry per robot.
    types : sequence of RobotType
        Masses, frictions and force bounds.
    step_s : float
        Time between two calls [s].

    Raises
    ------
    ConfigError
        If a sampled loop would be unstable at this step.
    """

    def __init__(self, gains: ServoGains, types: Sequence[RobotType], step_s: float) -> None:
        for robot_type, stiffness, damping in zip(types, gains.error, gains.speed, strict=True):
            _require_stability(robot_type, stiffness, damping, step_s)
        # Per axis, because an (n, 1) array that NumPy must stretch costs thrice as much in every step.
        self.gain_error, self.gain_speed = per_axis(gains.error), per_axis(gains.speed)
        self.force_max = np.array([robot_type.force_max_n for robot_type in types])
        self.step_s = step_s
        self.error: FloatArray = np.zeros((len(types), 2))

    def force(self, setpoints: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the drive force for the next step, and integrate the velocity error.

        Parameters
        ----------
        setpoints, velocities : (n, 2) array
            Wanted and true velocity, world frame [m/s].

        Returns
        -------
        (n, 2) array
            Force, world frame [N]; its magnitude is at most the type's bound.
        """
        error = self.error + self.step_s * (setpoints - velocities)
        force = self.gain_error * error - self.gain_speed * velocities
        squares = force * force
        magnitude = np.sqrt(squares[:, 0] + squares[:, 1])
        saturated = magnitude > self.force_max
        if np.count_nonzero(saturated):
            # Anti-windup: the integrator of a saturated robot rests.
            error[saturated] = self.error[saturated]
            force[saturated] *= (self.force_max[saturated] / magnitude[saturated])[:, None]
        self.error = error
        return force

    def subset(self, rows: IntArray) -> VelocityServo:
        """Return a servo of some of the robots, with a copy of their state."""
        part = copy(self)
        part.gain_error, part.gain_speed = self.gain_error[rows], self.gain_speed[rows]
        part.force_max, part.error = self.force_max[rows], self.error[rows]
        return part


class HeadingServo:
    """Turns at the commanded rate and holds the heading in between, against contacts.

    Parameters
    ----------
    yaws : (n,) array
        Headings at the start [rad].
    step_s : float
        Time between two calls [s].
    """

    def __init__(self, yaws: FloatArray, step_s: float) -> None:
        self._reference = yaws.astype(np.float64, copy=True)
        self._step_s = step_s

    def acceleration(self, rates: FloatArray, yaws: FloatArray, yaw_rates: FloatArray) -> FloatArray:
        """Return the angular acceleration for the next step, and move the heading reference.

        Parameters
        ----------
        rates : (n,) array
            Commanded turn rates [rad/s].
        yaws, yaw_rates : (n,) array
            True heading [rad] and turn rate [rad/s].

        Returns
        -------
        (n,) array
            Angular acceleration [rad/s^2].
        """
        error = wrap_angle(self._reference + self._step_s * rates - yaws)
        ahead = np.minimum(np.maximum(error, -HEADING_ERROR_MAX), HEADING_ERROR_MAX)
        reference = yaws + ahead
        acceleration = _STIFFNESS * ahead + _DAMPING * (rates - yaw_rates)
        if np.count_nonzero(rates) < len(rates):
            is_turning = rates != 0.0
            # A robot that is pushed around while it holds its heading remembers where to turn back to.
            reference = np.where(is_turning, reference, self._reference)
            # Without a dead band the motors would answer every bump of the ground.
            acceleration[(np.abs(acceleration) < _STIFFNESS * HEADING_TOLERANCE) & ~is_turning] = 0.0
        self._reference = reference
        bounded: FloatArray = np.minimum(np.maximum(acceleration, -HEADING_ACCELERATION_MAX), HEADING_ACCELERATION_MAX)
        return bounded


def per_axis(values: FloatArray) -> FloatArray:
    """Return a value of each robot, (n,), once for each axis, (n, 2)."""
    return np.repeat(values[:, None], 2, axis=1)


def wrap_angle(angles: FloatArray) -> FloatArray:
    """Return equal angles in [-pi, pi)."""
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def _require_stability(robot_type: RobotType, stiffness: float, damping: float, step_s: float) -> None:
    """Check the poles of the sampled loop [v, e], with the force held over a step."""
    decay, gain, *_ = held_force_response(robot_type, step_s)
    loop = np.array(
        [[decay - gain * (stiffness * step_s + damping), gain * stiffness], [-step_s, 1.0]],
    )
    if np.abs(np.linalg.eigvals(loop)).max() >= 1.0:
        raise ConfigError(
            f"physics.rate_hz: {1.0 / step_s:.0f} Hz is too slow for the servo gains of robot type {robot_type.type} "
            f"(K_e = {stiffness:.0f}, K_v = {damping:.0f}); raise the rate or use servo.gains 'recommended'"
        )


def held_force_response(robot_type: RobotType, step_s: float) -> tuple[float, float, float, float]:
    """Return the exact response of ``m dv/dt = F - b v`` to a force held over one step.

    Returns
    -------
    (a, g, p, q)
        ``v' = a v + g F`` and ``x' = x + p v + q F``.
    """
    mass, friction = robot_type.mass_kg, robot_type.mu2
    rate = friction / mass * step_s
    if rate < 1e-6:  # below it the quotients lose more digits than the first-order series
        decay = 1.0 - rate
        return decay, step_s / mass * (1.0 - rate / 2.0), step_s * (1.0 - rate / 2.0), step_s**2 / (2.0 * mass)
    decay = float(np.exp(-rate))
    glide = -float(np.expm1(-rate)) / rate * step_s
    return decay, glide / mass, glide, (step_s - glide) / friction
