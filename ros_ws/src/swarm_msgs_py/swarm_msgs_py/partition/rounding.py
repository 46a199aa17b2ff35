"""Rounding that takes away what differs between processors and libraries: the last bits."""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.types import FloatArray

GRID = 2.0**20  # parts of a meter to which points are rounded, so that rounding errors do not grow
FINE = 2.0**40  # parts of 1 to which sines are rounded: libraries differ in the last bits of these, 1e-16


def on_grid(values: FloatArray) -> FloatArray:
    """Return the nearest multiples of 2^-20: of coordinates, about a micrometer.

    Values that are equal but for last bits become equal, unless they meet the very border between two multiples. So
    does what is equal by symmetry, before the first of the least or the greatest is chosen.
    """
    rounded: FloatArray = np.rint(GRID * values) / GRID + 0.0  # no negative zeros
    return rounded


def direction(angle: float) -> FloatArray:
    """Return the (2,) unit vector at an angle [rad], the same on every processor and with every mathematical library.

    Its length is 1 up to 1e-12.
    """
    vector: FloatArray = np.rint(FINE * np.array([math.cos(angle), math.sin(angle)])) / FINE
    return vector
