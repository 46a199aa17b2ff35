"""PID per axis on the pose error, with a filtered derivative and conditional integration: the baseline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.boats.pose_control import YAW, Reference, pose_error


@dataclass(frozen=True, slots=True)
class PidGains:
    """Gains in terms of acceleration; x and y are alike, as the hull is.

    Attributes
    ----------
    planar, yaw : (float, float, float)
        Proportional [1/s^2], integral [1/s^3] and derivative [1/s] gain.
    filter_s, yaw_filter_s : float
        Time constant of the derivative's filter [s].
    """

    planar: tuple[float, float, float]
    yaw: tuple[float, float, float]
    filter_s: float
    yaw_filter_s: float


class PosePid:
    """The law for n boats; implements `PoseController`.

    Parameters
    ----------
    gains : sequence of PidGains
        Of each boat, or one for all.
    poses : (n, 3) array
        First measurement.
    step_s : float
        Time between two calls [s].
    """

    def __init__(self, gains: Sequence[PidGains], poses: FloatArray, step_s: float) -> None:
        table = np.array([[one.planar, one.planar, one.yaw] for one in gains])
        self._proportional, self._integral, self._derivative = np.moveaxis(table, 2, 0)
        filters = np.array([[one.filter_s, one.filter_s, one.yaw_filter_s] for one in gains])
        self._share = -np.expm1(-step_s / filters)
        self._step_s = step_s
        self._poses = poses.copy()
        self._velocity = np.zeros_like(poses)
        self._sum = np.zeros_like(poses)
        self._growth = np.zeros_like(poses)

    def command(self, measured: FloatArray, reference: Reference, docked: BoolArray) -> FloatArray:
        """Return the acceleration to make; see `PoseController.command`."""
        del docked
        rate = pose_error(measured, self._poses) / self._step_s
        self._poses = measured.copy()
        self._velocity = self._velocity + self._share * (rate - self._velocity)
        error = pose_error(reference.poses, measured)
        self._growth = self._step_s * self._integral * error
        self._sum = self._sum + self._growth
        steady = self._proportional * error + self._derivative * (reference.velocities - self._velocity)
        return np.asarray(steady + self._sum + reference.accelerations)

    def applied(self, accelerations: FloatArray, is_cut: BoolArray) -> None:
        """Take back what the integrators gained in this step where the thrusters are at their limit."""
        del accelerations
        self._sum[is_cut, :YAW] -= self._growth[is_cut, :YAW]
