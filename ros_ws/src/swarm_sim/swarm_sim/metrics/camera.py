"""How well the camera, and with it the robots, knew where robots were and which way they faced."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId

FALSE_M = 0.03
"""A fix that is farther than this from its robot [m] is of something else; less than half of the smallest cover."""

View = Callable[[float, FloatArray], BoolArray]
"""Says whom (n,) an image shows that is taken at a time [s] of robots at positions (n, 2) [m]."""


def everybody(time: float, positions: FloatArray) -> BoolArray:  # noqa: ARG001 - one of several views
    """Return that all robots (n,) are in view."""
    return np.ones(len(positions), dtype=bool)


class CameraScores:
    """Compares the fixes of a run with the truth, image by image.

    Parameters
    ----------
    view : View
        Tells from the truth whom images show. What was read out of them has no say in that: a robot in an image that
        was refused as a whole was not found.

    Attributes
    ----------
    images, unread : int
        Taken, and how many of them were refused as a whole.
    in_view, found : int
        Robots that images showed, and how many of them had a true fix.
    false_fixes : int
        Fixes that are nowhere near the robot that they name.
    """

    def __init__(self, view: View = everybody) -> None:
        self._view = view
        self.images = self.unread = self.in_view = self.found = self.false_fixes = 0
        self._positions: list[float] = []
        self._headings: list[float] = []

    @property
    def position_errors(self) -> FloatArray:
        """Distances of true fixes from their robots, (f,) [m]."""
        return np.array(self._positions)

    @property
    def heading_errors(self) -> FloatArray:
        """Heading errors of true fixes, (f,) [rad]."""
        return np.array(self._headings)

    def take(self, report: CameraReport, row_of: dict[NodeId, int], positions: FloatArray, yaws: FloatArray) -> None:
        """Count one image.

        Parameters
        ----------
        report : CameraReport
        row_of : dict
            Row of each robot in the arrays.
        positions : (n, 2) array
            True, when the image was taken [m].
        yaws : (n,) array
            Likewise [rad].
        """
        self.images += 1
        self.unread += report.status is not CameraStatus.OK
        shown = self._view(report.time, positions)
        self.in_view += int(shown.sum())
        for fix in report.fixes:
            row = row_of[fix.robot]
            error = math.hypot(*(fix.position - positions[row]).tolist())
            if error > FALSE_M:
                self.false_fixes += 1
                continue
            self.found += int(shown[row])
            self._positions.append(error)
            self._headings.append(math.remainder(fix.yaw - float(yaws[row]), math.tau))


def heading_errors(believed: FloatArray, truth: FloatArray) -> FloatArray:
    """Return believed minus true headings the short way around, of any shape [rad]."""
    errors: FloatArray = np.remainder(believed - truth + np.pi, 2.0 * np.pi) - np.pi
    return errors
