"""Gains of the velocity servo: LQR with integral action on m dv/dt = F - b v.

Thesis section 3.3, eq. (3.108)-(3.111) and table 4.2; spec section 12.2. State ``[v, e]``, e = integral of the
velocity error (erratum E22), control law ``F = K_e e - K_v v``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_are

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import GainSet

RECOMMENDED_STIFFNESS = 141.6
"""K_e / m of the recommended set [1/s^2]: a natural frequency of 11.9 rad/s (spec section 12.2)."""

WEIGHT_SPEED = 1.0 / (1.5 * 1.0**2)
"""q1 = 1 / (t1 x1max^2), t1 = 1.5 s, x1max = 1 m/s: thesis eq. (3.109)-(3.110)."""
WEIGHT_ERROR = 1.0 / (0.01 * 4.0**2)
"""q2 = 1 / (t2 x2max^2), t2 = 0.01 s, x2max = 4 m."""
WEIGHT_FORCE = 1.0 / 3.0**2
"""R = 1 / F_max^2, F_max = 3 N: thesis eq. (3.111)."""

TABLE_4_2 = {1: (237.0, 96.0), 2: (263.0, 112.0), 3: (297.0, 121.0)}
"""(K_e, K_v) of thesis table 4.2, by type number."""


@dataclass(frozen=True, slots=True, eq=False)
class ServoGains:
    """Gains of one or more servos.

    Attributes
    ----------
    error : (n,) array
        K_e [N/m]: force per integrated velocity error.
    speed : (n,) array
        K_v [N s/m]: force per velocity.
    """

    error: FloatArray
    speed: FloatArray


def lqr_gains(mass: float, friction: float, weights: tuple[float, float, float]) -> tuple[float, float]:
    """Return (K_e, K_v) that minimize the integral of ``q1 v^2 + q2 e^2 + r F^2``, by the algebraic Riccati equation.

    Parameters
    ----------
    mass, friction : float
        m [kg] and b [N s/m] of the vehicle.
    weights : (q1, q2, r)
        Cost of speed, of integrated error and of force; q2, r > 0.
    """
    q1, q2, r = weights
    # The regulator form of thesis eq. (3.108): de/dt = v. In operation de/dt = v_set - v, which turns the sign of K_e.
    dynamics = np.array([[-friction / mass, 0.0], [1.0, 0.0]])
    drive = np.array([[1.0 / mass], [0.0]])
    cost = solve_continuous_are(dynamics, drive, np.diag([q1, q2]), np.array([[r]]))
    speed, error = (drive.T @ cost / r)[0]
    return float(error), float(speed)


def lqr_gains_closed_form(mass: float, friction: float, weights: tuple[float, float, float]) -> tuple[float, float]:
    """Return (K_e, K_v) as `lqr_gains` does, from the closed form of the 2 x 2 Riccati equation."""
    q1, q2, r = weights
    error = np.sqrt(q2 / r)
    return float(error), float(-friction + np.sqrt(friction**2 + q1 / r + 2.0 * mass * error))


def gains_of(robot_type: RobotType, gain_set: GainSet) -> tuple[float, float]:
    """Return (K_e, K_v) of one type of robot.

    Raises
    ------
    ConfigError
        If table 4.2 is asked for a type that it does not list.
    """
    if gain_set is GainSet.TABLE_4_2:
        if robot_type.type not in TABLE_4_2:
            raise ConfigError(f"servo.gains: table 4.2 has no robot type {robot_type.type}; use 'recommended'")
        return TABLE_4_2[robot_type.type]
    if gain_set is GainSet.WEIGHTS:
        weights = (WEIGHT_SPEED, WEIGHT_ERROR, WEIGHT_FORCE)
    else:
        weights = (0.0, (RECOMMENDED_STIFFNESS * robot_type.mass_kg) ** 2, 1.0)
    return lqr_gains(robot_type.mass_kg, robot_type.mu2, weights)


def servo_gains(types: Sequence[RobotType], gain_set: GainSet) -> ServoGains:
    """Return the gains of a swarm, one entry per robot."""
    by_type = {robot_type: gains_of(robot_type, gain_set) for robot_type in dict.fromkeys(types)}
    table = np.array([by_type[robot_type] for robot_type in types])
    return ServoGains(error=table[:, 0].copy(), speed=table[:, 1].copy())
