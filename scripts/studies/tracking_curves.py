"""The two curves of the tracking study, driven at constant speed with the heading held."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

import numpy as np

from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.pose_control import Reference

SPEED_MPS = 0.15
"""Speed along the curve (digest, section 13) [m/s]."""
RADIUS_M = 1.2
EIGHT_M = 2.0
"""Half the width of the figure-eight [m]."""
SAMPLES = 20_000
"""Points in which a curve is measured."""


class CurveKind(Enum):
    """Which curve."""

    CIRCLE = "circle"
    EIGHT = "figure-eight"


def _circle(angle: FloatArray) -> FloatArray:
    return RADIUS_M * np.column_stack([np.cos(angle), np.sin(angle)])


def _eight(angle: FloatArray) -> FloatArray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([EIGHT_M * cos, 2.0 * EIGHT_M * sin * cos]) / (1.0 + sin**2)[:, None]


_SHAPES: dict[CurveKind, Callable[[FloatArray], FloatArray]] = {CurveKind.CIRCLE: _circle, CurveKind.EIGHT: _eight}


class Curve:
    """A closed curve by arc length.

    Parameters
    ----------
    kind : CurveKind

    Attributes
    ----------
    length_m : float
    """

    def __init__(self, kind: CurveKind) -> None:
        points = _SHAPES[kind](np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1))
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self._arcs = np.concatenate([[0.0], np.cumsum(gaps)])
        self._points = points
        self.length_m = float(self._arcs[-1])

    def points(self, arcs: FloatArray) -> FloatArray:
        """Return the points (k, 2) at arc lengths (k,) [m]."""
        wrapped = arcs % self.length_m
        return np.column_stack([np.interp(wrapped, self._arcs, column) for column in self._points.T])

    def references(self, times: FloatArray) -> FloatArray:
        """Return x, y, their velocities and accelerations at times (k,), (k, 6)."""
        ahead = 0.02  # [s] long against the polygon's edges, short against a turn
        before, here, after = (self.points(SPEED_MPS * (times + shift)) for shift in (-ahead, 0.0, ahead))
        return np.column_stack([here, (after - before) / (2.0 * ahead), (after - 2.0 * here + before) / ahead**2])


def reference_of(row: FloatArray, count: int) -> Reference:
    """Return one row of `Curve.references` as the reference of `count` boats that keep the heading 0."""
    still = np.zeros((count, 3))
    poses, velocities, accelerations = still.copy(), still.copy(), still.copy()
    poses[:, :2], velocities[:, :2], accelerations[:, :2] = row[:2], row[2:4], row[4:]
    return Reference(poses, velocities, accelerations)
