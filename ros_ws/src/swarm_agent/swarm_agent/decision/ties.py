"""Which of several equally cheap assignments counts: one rule, so that no two solvers, old or new, fall out over it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import IntArray


def first_of_the_best(costs: IntArray, allowed: NDArray[np.bool_], rows: IntArray, columns: IntArray) -> list[int]:
    """Return, of all assignments as cheap as the one given, the one with the lowest column for the lowest rows.

    By the theory of linear programming (complementary slackness), the cheapest assignments are just those within the
    entries of zero reduced cost, whichever optimal potentials reduce them.

    Parameters
    ----------
    costs : (n, m) int array
        Costs; a row without a column, or a column without a row, costs nothing.
    allowed : (n, m) bool array
        Where a row may have a column at all; elsewhere the cost is a penalty for having none.
    rows, columns : (k,) int array
        An assignment of least total cost, k = min(n, m).

    Returns
    -------
    list of int
        Column of each row, -1 for none, which comes after all columns.
    """
    n, m = costs.shape
    size = max(n, m)
    square, wanted = np.zeros((size, size), dtype=np.int64), np.zeros((size, size), dtype=np.bool_)
    square[:n, :m], wanted[:n, :m] = costs, allowed
    column_of = _completed(size, rows, columns)
    tight = _tight(square, column_of)
    if _has_ring(tight[:, column_of]):  # else there is no other
        _lower(tight, wanted, column_of, n)
    return [int(column) if wanted[row, column] else -1 for row, column in enumerate(column_of[:n])]


def _completed(size: int, rows: IntArray, columns: IntArray) -> IntArray:
    """Return the column of each of `size` rows; who is left over is paired in order."""
    column_of = np.full(size, -1, dtype=np.int64)
    column_of[rows] = columns
    is_left = np.ones(size, dtype=np.bool_)
    is_left[columns] = False
    column_of[column_of < 0] = np.flatnonzero(is_left)
    return column_of


def _tight(square: IntArray, column_of: IntArray) -> NDArray[np.bool_]:
    """Return where the reduced cost is zero under potentials for which none is negative, (n, n)."""
    # What it costs row r to take the column of row s; shortest paths over it are potentials (Bellman-Ford).
    dearer = square[:, column_of] - np.diagonal(square[:, column_of])[:, None]
    potentials = np.zeros(len(square), dtype=np.int64)
    for _ in range(len(square)):
        relaxed = (potentials[:, None] + dearer).min(axis=0)
        if (relaxed == potentials).all():
            break
        potentials = relaxed
    tight = np.empty(square.shape, dtype=np.bool_)
    tight[:, column_of] = dearer + potentials[:, None] == potentials[None]
    return tight


def _has_ring(may_take: NDArray[np.bool_]) -> bool:
    """Return whether rows can pass their columns on in a ring, if row r may take that of row s, (n, n)."""
    np.fill_diagonal(may_take, val=False)
    left = np.ones(len(may_take), dtype=np.bool_)
    while left.any():
        untaken = left & ~may_take[left].any(axis=0)
        if not untaken.any():
            return True
        left &= ~untaken
    return False


def _lower(tight: NDArray[np.bool_], wanted: NDArray[np.bool_], column_of: IntArray, count: int) -> None:
    """Give each of the first rows in turn the lowest column that leaves the others a complete assignment, in place."""
    row_of = np.argsort(column_of)
    for row in range(count):
        for column in np.flatnonzero(tight[row] & wanted[row]).tolist():
            chain = _chain(tight, column_of, row_of, row, column)
            if chain is None:
                continue
            for taker, taken in chain:
                column_of[taker], row_of[taken] = taken, taker
            tight[:, column] = tight[row] = False  # settled
            break
        else:
            tight[row] &= ~wanted[row]  # nothing for this row; which of the places for that is no matter


def _chain(
    tight: NDArray[np.bool_], column_of: IntArray, row_of: IntArray, row: int, column: int
) -> list[tuple[int, int]] | None:
    """Return who takes which column if `row` takes `column` and its owner moves on, down to who takes the old one."""
    if column == column_of[row]:
        return []
    before: dict[int, tuple[int, int]] = {column: (row, -1)}  # column: who takes it, and the column that it leaves
    queue = [column]
    for taken in queue:
        owner = int(row_of[taken])
        for other in np.flatnonzero(tight[owner]).tolist():
            if other in before:
                continue
            before[other] = (owner, taken)
            if other == column_of[row]:
                return _unwound(before, other)
            queue.append(other)
    return None


def _unwound(before: dict[int, tuple[int, int]], last: int) -> list[tuple[int, int]]:
    """Return the steps of a chain, the last one first."""
    chain, column = [], last
    while column >= 0:
        taker, left = before[column]
        chain.append((taker, column))
        column = left
    return chain
