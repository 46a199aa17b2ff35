"""A quasi-Newton minimizer whose result does not hang on the last bits of its inputs."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from swarm_msgs_py.partition.rounding import on_grid
from swarm_msgs_py.types import FloatArray

MEMORY = 7  # steps from which the curvature is estimated
DECREASE = 1e-4  # share of the expected decrease that a step must bring (Armijo)
CURVATURE_MIN = 1e-10  # a step along which the slope hardly changes says nothing about curvature
HALVINGS = 8  # of a step that brings too little

EnergyFunction = Callable[[FloatArray], tuple[float, FloatArray]]


def minimize(
    function: EnergyFunction, start: FloatArray, *, step_max: float, tolerance: float, steps_max: int
) -> FloatArray:
    """Return points of a local minimum, by limited-memory BFGS with a backtracking line search.

    Rounding errors differ between processors and libraries, and a descent can make them grow. Here points are rounded
    to a micrometer after every step and products are summed without rounding, so that they vanish instead.

    Parameters
    ----------
    function : callable
        Returns the value at (n, 2) points and its (n, 2) gradient, scaled so that the first step may be the negative
        gradient.
    start : (n, 2) array
        [m].
    step_max : float
        Farthest that a point moves in a step [m].
    tolerance : float
        Ends when no point is to move farther [m].
    steps_max : int
        Ends after this many steps.

    Returns
    -------
    (n, 2) array
        [m].

    References
    ----------
    .. [1] J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., Springer, 2006, algorithm 7.4.
    .. [2] Y. Liu et al., "On centroidal Voronoi tessellation - energy smoothness and fast computation", ACM
       Transactions on Graphics 28(4), 2009.
    """
    points = on_grid(start)
    value, gradient = function(points)
    memory: deque[tuple[FloatArray, FloatArray, float]] = deque(maxlen=MEMORY)
    for _ in range(steps_max):
        step = -_times_inverse_hessian(gradient, memory)
        longest = float(np.abs(step).max())
        if longest < tolerance:
            break
        step *= min(1.0, step_max / longest)
        slope = _dot(gradient, step)
        share = 1.0
        for _ in range(HALVINGS):
            moved = on_grid(points + share * step)
            new_value, new_gradient = function(moved)
            if new_value <= value + DECREASE * share * slope:
                break
            share /= 2.0
        else:
            if not memory:
                break
            memory.clear()  # what it remembers of another place misleads; once more along the gradient
            continue
        change, turn = moved - points, new_gradient - gradient
        curvature = _dot(change, turn)
        if curvature > CURVATURE_MIN * _dot(turn, turn):
            memory.append((change, turn, curvature))
        points, value, gradient = moved, new_value, new_gradient
    return points


def _times_inverse_hessian(gradient: FloatArray, memory: deque[tuple[FloatArray, FloatArray, float]]) -> FloatArray:
    """Return the product of the estimated inverse Hessian and the gradient (two-loop recursion)."""
    result = gradient
    shares = []
    for change, turn, curvature in reversed(memory):
        share = _dot(change, result) / curvature
        shares.append(share)
        result = result - share * turn
    if memory:
        _, turn, curvature = memory[-1]
        result = result * (curvature / _dot(turn, turn))
    for (change, turn, curvature), share in zip(memory, reversed(shares), strict=True):
        result = result + (share - _dot(turn, result) / curvature) * change
    return result


def _dot(one: FloatArray, other: FloatArray) -> float:
    return math.fsum((one * other).ravel().tolist())
