"""How well the camera, and with it the robots, knew where robots were and which way they faced."""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus
from swarm_msgs_py.types import FloatArray, NodeId

FALSE_M = 0.05
"""A fix that is farther than this from its robot is not of this robot [m]."""
DEAD_SHARE_MAX = 0.1
"""Of an image that shows less than the rest, who is not found was not in view."""


class CameraScores:
    """Compares the fixes of a run with the truth, image by image.

    Attributes
    ----------
    images : int
        Taken.
    in_view, found : int
        Robots that images showed, which are all in those that are whole; and how many of them had a true fix.
    false_fixes : int
        Fixes that are nowhere near the robot that they name.
    """

    def __init__(self) -> None:
        self.images = self.in_view = self.found = self.false_fixes = 0
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
        is_whole = report.status is CameraStatus.OK and report.dead_share < DEAD_SHARE_MAX
        self.in_view += len(row_of) * is_whole
        for fix in report.fixes:
            row = row_of[fix.robot]
            error = math.hypot(*(fix.position - positions[row]).tolist())
            if error > FALSE_M:
                self.false_fixes += 1
                continue
            self.found += is_whole
            self._positions.append(error)
            self._headings.append(math.remainder(fix.yaw - float(yaws[row]), math.tau))


def heading_errors(believed: FloatArray, truth: FloatArray) -> FloatArray:
    """Return believed minus true headings the short way around, of any shape [rad]."""
    errors: FloatArray = np.remainder(believed - truth + np.pi, 2.0 * np.pi) - np.pi
    return errors
