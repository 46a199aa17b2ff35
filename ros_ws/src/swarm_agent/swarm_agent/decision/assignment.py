"""Who takes which goal: the one-to-one assignment of least total cost, or of the shortest longest path.

A goal may be taken by robots of one type only, so there is one problem per type. Cost is path length times the robot's
weight, a whole number. As many robots as possible get a goal that they have a path to; among those assignments

* `Objective.TOTAL` takes the least sum of costs;
* `Objective.BOTTLENECK` takes the least largest cost, and among those the least sum.

The largest cost of the swarm is the largest of its types, and no type's assignment bears on another's. So the least
there is for the swarm is the largest of the types' own optima: that *threshold* is set by the critical type alone, and
every other type may spend up to it. Each then takes the least sum under the common threshold, which is never more than
under its own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from swarm_agent.decision.ties import first_of_the_best
from swarm_msgs_py.messages.bodies import UNREACHABLE, CostRow, Objective
from swarm_msgs_py.types import IntArray, NodeId

_FORBIDDEN = -1
"""Cost of a goal without a path."""


def assign(rows: Iterable[CostRow]) -> dict[NodeId, int]:
    """Return the goal of each robot, as the position in its cost row.

    Every robot that holds the same rows finds the same answer: the rows are put in order of robot id, costs are whole
    numbers, and ties go to the lowest goal of the lowest robot. What is minimized is what `agreed_objective` says.

    Parameters
    ----------
    rows : iterable of CostRow
        One row per robot; rows of one type are for the same goals.

    Returns
    -------
    dict
        Robot to goal position. A robot is absent when there are fewer goals than robots, or no path to what is left.

    References
    ----------
    Thesis algorithm 6 (Hungarian method), corrected as in erratum E17; solved by SciPy's modified Jonker-Volgenant.
    R. Burkard, M. Dell'Amico, S. Martello, "Assignment Problems", SIAM 2009, section 6.2 (threshold method).
    """
    ordered = sorted(rows, key=lambda row: row.robot)
    groups: defaultdict[int, list[CostRow]] = defaultdict(list)
    for row in ordered:
        groups[row.robot_type].append(row)
    problems = {kind: _weighted(group) for kind, group in groups.items()}
    threshold = None
    if agreed_objective(ordered) is Objective.BOTTLENECK:
        threshold = max(_bottleneck(costs.tobytes(), costs.shape) for costs in problems.values())
    return {
        groups[kind][index].robot: goal
        for kind, costs in problems.items()
        for index, goal in _cheapest(costs.tobytes(), costs.shape, threshold)
    }


def agreed_objective(rows: Sequence[CostRow]) -> Objective:
    """Return what most of the rows would minimize; the total if there are as many for the one as for the other.

    It is part of the rows, so robots with different settings still take different goals.
    """
    votes = sum(row.objective is Objective.BOTTLENECK for row in rows)
    return Objective.BOTTLENECK if 2 * votes > len(rows) else Objective.TOTAL


def _weighted(rows: Sequence[CostRow]) -> IntArray:
    """Return weight times path length, (n, m); `_FORBIDDEN` where there is no path."""
    costs = np.array([row.costs for row in rows], dtype=np.int64)
    weights = np.array([row.weight for row in rows], dtype=np.int64)
    return np.where(costs == UNREACHABLE, _FORBIDDEN, costs * weights[:, None])


@lru_cache(maxsize=128)  # all robots of a process hold the same rows: solve once, not fifty times
def _bottleneck(data: bytes, shape: tuple[int, int]) -> int:
    """Return the least number that the largest cost of an assignment can be, by bisection over the costs there are."""
    costs = np.frombuffer(data, dtype=np.int64).reshape(shape)
    steps = np.unique(costs[costs != _FORBIDDEN])
    if not len(steps):
        return 0
    most = _matched(costs != _FORBIDDEN)
    low, high = 0, len(steps) - 1
    while low < high:
        middle = (low + high) // 2
        if _matched((costs != _FORBIDDEN) & (costs <= steps[middle])) == most:
            high = middle
        else:
            low = middle + 1
    return int(steps[low])


def _matched(allowed: NDArray[np.bool_]) -> int:
    """Return how many robots can have a goal of their own at once (Hopcroft-Karp)."""
    matching = maximum_bipartite_matching(csr_array(allowed.astype(np.int8)), perm_type="column")
    return int((matching >= 0).sum())


@lru_cache(maxsize=128)
def _cheapest(data: bytes, shape: tuple[int, int], threshold: int | None) -> tuple[tuple[int, int], ...]:
    """Return pairs of row and goal of the least sum, no cost above the threshold."""
    costs = np.frombuffer(data, dtype=np.int64).reshape(shape)
    allowed = costs != _FORBIDDEN
    if threshold is not None:
        allowed &= costs <= threshold
    # More than any sum of allowed costs, so that it is paid only where nothing else is left.
    penalty = 1 + int(np.where(allowed, costs, 0).max(axis=1, initial=0).sum())
    penalized = np.where(allowed, costs, penalty)
    goals = first_of_the_best(penalized, allowed, *linear_sum_assignment(penalized))
    return tuple((row, goal) for row, goal in enumerate(goals) if goal >= 0)
