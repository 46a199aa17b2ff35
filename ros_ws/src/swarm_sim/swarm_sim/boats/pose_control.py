"""What a pose controller is given and what it gives; the same for all laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from swarm_msgs_py.types import BoolArray, FloatArray

YAW = 2
"""Column of the heading in a pose."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Where boats are to be, world frame.

    Attributes
    ----------
    poses, velocities, accelerations : (n, 3) array
        x, y [m] and heading [rad], and their derivatives.
    """

    poses: FloatArray
    velocities: FloatArray
    accelerations: FloatArray


class PoseController(Protocol):
    """Turns measured poses into accelerations, once per control step."""

    def command(self, measured: FloatArray, reference: Reference, docked: BoolArray) -> FloatArray:
        """Return the acceleration to make.

        Parameters
        ----------
        measured : (n, 3) array
            Poses, world frame [m], [rad].
        reference : Reference
        docked : (n,) bool array
            Who is held by another boat.

        Returns
        -------
        (n, 3) array
            World frame [m/s^2], [rad/s^2].
        """
        ...

    def applied(self, accelerations: FloatArray, is_cut: BoolArray) -> None:
        """Learn what the thrusters will make of the command in this step.

        Parameters
        ----------
        accelerations : (n, 3) array
            World frame, of limited thrusts [m/s^2], [rad/s^2].
        is_cut : (n,) bool array
            Whose thrusters could not do what was asked.
        """
        ...


def pose_error(wanted: FloatArray, poses: FloatArray) -> FloatArray:
    """Return wanted minus actual poses (n, 3), headings in [-pi, pi)."""
    error = wanted - poses
    error[:, YAW] = (error[:, YAW] + np.pi) % (2.0 * np.pi) - np.pi
    return error
