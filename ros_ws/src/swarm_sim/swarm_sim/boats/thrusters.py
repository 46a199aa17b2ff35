"""Four thrusters in a plus: allocation of a wrench, saturation, lag and dead band; vectorized over boats.

Thrusters 1 and 3 push along the body's y axis, 2 and 4 along its x axis (paper, eq. (1)). The rows of that matrix are
orthogonal, so the least-squares allocation has a closed form.
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import ThrusterConfig

COUNT = 4
"""Thrusters of a boat."""


def allocation_matrix(arm_m: float) -> FloatArray:
    """Return E, (3, 4): surge force, sway force and yaw moment of unit thrusts (paper, eq. (1))."""
    lever = arm_m
    return np.array([[0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.0], [lever, -lever, -lever, lever]])


def allocate(wrenches: FloatArray, arm_m: float) -> FloatArray:
    """Return the least thrusts that make up wrenches.

    Parameters
    ----------
    wrenches : (n, 3) array
        Surge force, sway force [N] and yaw moment [N m], body frame.
    arm_m : float
        Lever of each thruster [m].

    Returns
    -------
    (n, 4) array
        Thrusts [N].
    """
    surge, sway, yaw = 0.5 * wrenches[:, 0], 0.5 * wrenches[:, 1], wrenches[:, 2] / (COUNT * arm_m)
    return np.column_stack([sway + yaw, surge - yaw, sway - yaw, surge + yaw])


def feasible(wrenches: FloatArray, config: ThrusterConfig) -> FloatArray:
    """Return the wrenches that the thrusters can make: the yaw moment first, and the force in its direction.

    A boat that turned away could not hold its place either, and a force that is cut per axis would point elsewhere.
    """
    limit = config.force_max_n
    yaw = np.clip(wrenches[:, 2] / (COUNT * config.arm_m), -limit, limit)
    largest = 0.5 * np.abs(wrenches[:, :2]).max(axis=1)
    room = limit - np.abs(yaw)
    scale = np.where(largest > room, room / np.maximum(largest, 1e-12), 1.0)
    return np.column_stack([wrenches[:, :2] * scale[:, None], yaw * (COUNT * config.arm_m)])


class Thrusters:
    """Thrusts of all boats, with lag and dead band.

    Parameters
    ----------
    config : ThrusterConfig
    count : int
        Boats.
    step_s : float
        Time between two calls [s].

    Attributes
    ----------
    thrusts : (n, 4) array
        What the thrusters give now [N].
    """

    def __init__(self, config: ThrusterConfig, count: int, step_s: float) -> None:
        self._config = config
        self._matrix = allocation_matrix(config.arm_m)
        self._share = 1.0 - np.exp(-step_s / config.lag_s) if config.lag_s > 0.0 else 1.0
        self.thrusts: FloatArray = np.zeros((count, COUNT))

    def drive(self, wrenches: FloatArray) -> FloatArray:
        """Command wrenches (n, 3) in the body frame for one step, and return those that come out, (n, 3)."""
        commands = allocate(feasible(wrenches, self._config), self._config.arm_m)
        commands[np.abs(commands) < self._config.dead_band_n] = 0.0
        self.thrusts = self.thrusts + self._share * (commands - self.thrusts)
        return self.thrusts @ self._matrix.T
