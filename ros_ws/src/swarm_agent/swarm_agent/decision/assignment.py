"""Who takes which goal: the one-to-one assignment of least total cost."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.optimize import linear_sum_assignment

from swarm_msgs_py.messages.bodies import UNREACHABLE, CostRow
from swarm_msgs_py.types import IntArray, NodeId

_UNREACHABLE_PENALTY = 10_000_000
"""Cost [cm] of a goal without a path: more than any sum of real costs, so that it is taken last."""


def assign(rows: tuple[CostRow, ...]) -> dict[NodeId, int]:
    """Return the goal of each robot of one type, as the position in its cost row.

    Every robot that holds the same rows finds the same answer: the rows are put in order of robot id, costs are whole
    centimeters, and the solver is deterministic, so ties fall the same way everywhere.

    Parameters
    ----------
    rows : tuple of CostRow
        One row per robot of one type, all for the same goals.

    Returns
    -------
    dict
        Robot to goal position. A robot is absent when there are fewer goals than robots, or no path to what is left.

    References
    ----------
    Thesis algorithm 6 (Hungarian method), corrected as in erratum E17; solved by SciPy's modified Jonker-Volgenant.
    """
    ordered = sorted(rows, key=lambda row: row.robot)
    key = tuple((row.robot, row.costs.tobytes()) for row in ordered)
    return _assign(key, str(ordered[0].costs.dtype)) if ordered else {}


@lru_cache(maxsize=64)  # all robots of a process hold the same rows: solve once, not fifty times
def _assign(key: tuple[tuple[NodeId, bytes], ...], dtype: str) -> dict[NodeId, int]:
    costs = np.array([np.frombuffer(row, dtype=dtype) for _, row in key], dtype=np.int64)
    return {key[index][0]: goal for index, goal in _match(costs)}


def _match(costs: IntArray) -> list[tuple[int, int]]:
    penalized = np.where(costs == UNREACHABLE, _UNREACHABLE_PENALTY, costs)
    rows, columns = linear_sum_assignment(penalized)
    return [(int(r), int(c)) for r, c in zip(rows, columns, strict=True) if costs[r, c] != UNREACHABLE]
