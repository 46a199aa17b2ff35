"""Distances from starts to targets, and assignments that keep them short."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from swarm_msgs_py.assembly.faces import Layout, layout_class
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.types import IntArray


def travel_matrix(problem: AssemblyProblem) -> IntArray:
    """Return the distance from each start to each target, (n, m) [cells]."""
    starts, targets = (np.array(cells, dtype=np.int64).reshape(-1, 2) for cells in (problem.starts, problem.targets))
    distances: IntArray = np.abs(starts[:, None] - targets[None]).sum(axis=2)
    return distances


def usable_boats(problem: AssemblyProblem) -> tuple[int, ...]:
    """Return the boats that may take a target: those with a mechanism, or all if one boat is the structure."""
    return tuple(boat for boat, layout in enumerate(problem.layouts) if any(layout) or problem.target_count == 1)


def least_longest_travel(problem: AssemblyProblem, boats: Sequence[int] | None = None) -> int:
    """Return the least longest travel of any assignment, docks ignored: a lower bound of all dispatches."""
    return _least_longest(travel_matrix(problem)[list(usable_boats(problem) if boats is None else boats)])


def _least_longest(distances: IntArray) -> int:
    """Return the least longest distance of any assignment of rows to all columns."""
    levels = np.unique(distances)
    low, high = 0, len(levels) - 1
    while low < high:
        middle = (low + high) // 2
        matching = maximum_bipartite_matching(csr_array(distances <= levels[middle]), perm_type="row")
        if (matching >= 0).all():
            high = middle
        else:
            low = middle + 1
    return int(levels[low])


def shortest_assignment(distances: IntArray) -> list[int]:
    """Return the row of each column so that long travels are few, then the total is small; exact for that cost.

    The cost of a travel is its square: it weighs the longest most, and keeps the total close to its least.
    """
    rows, columns = linear_sum_assignment(distances.astype(np.float64) ** 2)
    chosen = [-1] * distances.shape[1]
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        chosen[column] = row
    return chosen


def exchanged_within_classes(
    costs: IntArray, classes: Iterable[Sequence[int]], boats: Sequence[int], *, is_strict: bool
) -> list[int]:
    """Return the boat of each target after exchanges within classes: few long ways, then a small total.

    Parameters
    ----------
    costs : (n, m) int array
        Of each boat and target.
    classes : iterable of sequence of int
        Boats that may stand in for each other.
    boats : sequence of int
        Boat of each target, before.
    is_strict : bool
        Make the longest way as short as it can be, exactly; otherwise the sum of squares is least.
    """
    chosen = list(boats)
    tasks = []
    for members in classes:
        known = set(members)
        targets = [target for target, boat in enumerate(boats) if boat in known]
        if targets:
            tasks.append((members, targets, costs[np.ix_(members, targets)]))
    bound = max(_least_longest(part) for _, _, part in tasks) if is_strict else int(costs.max())
    out_of_question = costs.shape[1] * int(costs.max()) ** 2 + 1
    for members, targets, part in tasks:
        weights = np.where(part <= bound, part**2, out_of_question)
        rows, columns = linear_sum_assignment(weights)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            chosen[targets[column]] = members[row]
    return chosen


def distance_only_dispatch(problem: AssemblyProblem) -> Dispatch:
    """Return the dispatch of least total travel that knows nothing of docks: the negative control."""
    boats = usable_boats(problem)
    rows, columns = linear_sum_assignment(travel_matrix(problem)[list(boats)])
    chosen = [-1] * problem.target_count
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        chosen[column] = boats[row]
    return Dispatch(tuple(chosen), (0,) * problem.target_count)


def boats_by_class(problem: AssemblyProblem) -> Mapping[Layout, list[int]]:
    """Return the boats whose layouts are turns of one another, by the representative of their class."""
    classes: dict[Layout, list[int]] = {}
    for boat, layout in enumerate(problem.layouts):
        classes.setdefault(layout_class(layout), []).append(boat)
    return dict(sorted(classes.items()))
