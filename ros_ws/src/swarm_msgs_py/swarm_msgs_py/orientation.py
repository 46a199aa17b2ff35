"""Headings: as a rotation of vectors, and as a planar quaternion that gives back exactly what it was made from."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from swarm_msgs_py.types import FloatArray

SEARCH_ULPS = 4  # two roundings of at most one unit in the last place each, with room to spare


def rotation(yaw: float) -> FloatArray:
    """Return the matrix (2, 2) that turns vectors of the body frame into the world frame, for a heading [rad]."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([[cos, -sin], [sin, cos]])


def yaw_of(z: float, w: float) -> float:
    """Return the heading of the planar quaternion (0, 0, z, w) [rad], in [-2 pi, 2 pi]."""
    return 2.0 * math.atan2(z, w)


def quaternion_of(yaw: float) -> tuple[float, float]:
    """Return (z, w) of the planar unit quaternion of a heading, such that `yaw_of` returns the same number.

    The direct formula is off by a unit in the last place for about every other heading; then a run over messages would
    drift away from the same run in one process. Neighboring numbers of sine and cosine, which leave the quaternion as
    normalized as it was, are searched for a pair that gives the heading back.

    Parameters
    ----------
    yaw : float
        Heading [rad]. Beyond +/-2 pi the quaternion stands for the same direction, not for the same number.
    """
    z, w = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    if yaw_of(z, w) == yaw:
        return z, w
    for z_steps, w_steps in _STEPS:
        near = _stepped(z, z_steps), _stepped(w, w_steps)
        if yaw_of(*near) == yaw:
            return near
    return z, w


def _stepped(number: float, steps: int) -> float:
    """Return the float `steps` places away from `number`."""
    for _ in range(abs(steps)):
        number = math.nextafter(number, math.copysign(math.inf, steps))
    return number


_STEPS = sorted(
    product(range(-SEARCH_ULPS, SEARCH_ULPS + 1), repeat=2), key=lambda steps: (abs(steps[0]) + abs(steps[1]), steps)
)
