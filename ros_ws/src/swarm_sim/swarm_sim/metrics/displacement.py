"""How far the robots drove, and how little would have been enough (spec section 14.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.signal import butter, sosfiltfilt

from swarm_msgs_py.types import FloatArray, IntArray

CUTOFF_HZ = 1.0  # spec 14.3: shaking of the body on rough ground is not travel
ORDER = 2  # of the low-pass, run forward and backward, so that nothing is delayed


def path_lengths(positions: FloatArray, rate_hz: float) -> FloatArray:
    """Return the path length of each robot, (n,) [m].

    Parameters
    ----------
    positions : (s, n, 2) array
        True positions, evenly spaced in time [m].
    rate_hz : float
        Samples per second, above twice the cut-off of 1 Hz [Hz].

    Raises
    ------
    ValueError
        If the samples are too sparse for the low-pass.
    """
    if len(positions) < 2:
        return np.zeros(positions.shape[1])
    if rate_hz <= 2.0 * CUTOFF_HZ:
        raise ValueError(f"positions at {rate_hz:g} Hz cannot be low-passed at {CUTOFF_HZ:g} Hz; sample faster")
    low_pass = butter(ORDER, CUTOFF_HZ, fs=rate_hz, output="sos")
    # One and a half seconds of odd extension let the filter forget its start; a shorter run takes what it has.
    padding = min(round(1.5 * rate_hz), len(positions) - 1)
    smooth = sosfiltfilt(low_pass, positions, axis=0, padlen=padding)
    lengths: FloatArray = np.linalg.norm(np.diff(smooth, axis=0), axis=2).sum(axis=0)
    return lengths


@dataclass(frozen=True, slots=True, eq=False)
class DisplacementBound:
    """The cheapest way to serve the final goals from the start points.

    Attributes
    ----------
    total : float
        Sum of the path lengths [m].
    longest : float
        Longest of them [m]; over the speed limit it bounds the settling time (spec 14.4).
    goal_of : (n,) int array
        Goal of each robot, -1 for none.
    """

    total: float
    longest: float
    goal_of: IntArray


def displacement_bound(costs: FloatArray, robot_types: IntArray, goal_types: IntArray) -> DisplacementBound | None:
    """Return the optimal assignment per type, or None where some robot or goal of a type cannot be served.

    Parameters
    ----------
    costs : (n, g) array
        Shortest obstacle-free path from each start point to each goal, inf where there is none [m]. Entries of a
        robot and a goal of different types are not looked at.
    robot_types : (n,) int array
    goal_types : (g,) int array
        Of a type with fewer goals than robots (or the reverse), the cheapest choice counts.
    """
    goal_of = np.full(len(robot_types), -1, dtype=np.int64)
    for kind in np.unique(robot_types):
        robots, goals = np.flatnonzero(robot_types == kind), np.flatnonzero(goal_types == kind)
        block = costs[np.ix_(robots, goals)]
        try:
            rows, columns = linear_sum_assignment(block)
        except ValueError:  # some robot or goal has no free path at all
            return None
        goal_of[robots[rows]] = goals[columns]
    served = np.flatnonzero(goal_of >= 0)
    lengths = costs[served, goal_of[served]]
    return DisplacementBound(float(lengths.sum()), float(lengths.max(initial=0.0)), goal_of)
