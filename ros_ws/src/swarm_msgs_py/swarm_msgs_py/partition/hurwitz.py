"""Sizes of circles that fill an area without end: the rule behind randomized fractals (thesis eqs. (2.1)-(2.3))."""

from __future__ import annotations

import numpy as np
from scipy.special import zeta

from swarm_msgs_py.types import FloatArray


def hurwitz_radii(area: float, count: int, exponent: float, shift: float) -> FloatArray:
    """Return the radii of the first circles of the filling, largest first.

    Circle i = 0, 1, ... has the area ``area / (zeta(c, N) (i + N)^c)`` with the Hurwitz zeta function
    ``zeta(c, N) = sum_i (i + N)^-c``. All of them together have the whole area, so a process that places one after the
    other fills it, if it never gets stuck.

    Parameters
    ----------
    area : float
        To fill [m^2].
    count : int
        How many circles.
    exponent : float
        c > 1; the larger, the sooner circles become small.
    shift : float
        N > 0; the larger, the smaller is the first circle.

    Returns
    -------
    (count,) array
        [m].

    References
    ----------
    .. [1] J. Shier, P. Bourke, "An algorithm for random fractal filling of space", Computer Graphics Forum 32(8), 2013.
    """
    shares = (np.arange(count) + shift) ** -exponent / float(zeta(exponent, shift))
    radii: FloatArray = np.sqrt(area * shares / np.pi)
    return radii


def hurwitz_fill(count: int, exponent: float, shift: float) -> float:
    """Return which share of the area the first `count` circles of `hurwitz_radii` take."""
    return 1.0 - float(zeta(exponent, count + shift) / zeta(exponent, shift))
