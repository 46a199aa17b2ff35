"""Shortest way of a rigid group around what its boats perceive: A* on the group's configuration space."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable

from swarm_msgs_py.assembly.boat_frames import Move
from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.problem import CLEARANCE

_REACH = range(1 - CLEARANCE, CLEARANCE)
MOVES = tuple(move for move in Move if move is not Move.STAY)
"""Moves that go somewhere."""


def too_near(cells: Iterable[Cell]) -> set[Cell]:
    """Return the cells that no cell of another group may be on: the given ones and all around them."""
    return {(x + dx, y + dy) for x, y in cells for dx in _REACH for dy in _REACH}


def moved(cells: Iterable[Cell], by: Cell) -> list[Cell]:
    """Return cells shifted by some columns and rows."""
    dx, dy = by
    return [(x + dx, y + dy) for x, y in cells]


def group_path(
    places: Collection[Cell],
    start: Cell,
    goals: Collection[Cell],
    grid: tuple[Cell, Cell],
    forbidden: Collection[Cell],
) -> list[Cell] | None:
    """Return the shifts of a group on a shortest way to one of its goals.

    Parameters
    ----------
    places : collection of Cell
        Cells of the group at shift (0, 0).
    start : Cell
        Its shift now.
    goals : collection of Cell
        Shifts that it may end at, not empty.
    grid : tuple of Cell
        Lowest cell of the grid, and its columns and rows.
    forbidden : collection of Cell
        Cells that it must not be on; the start may violate that.

    Returns
    -------
    list of Cell or None
        Shifts from the next one on, empty if the group is at a goal; None if there is no way.
    """
    origin, size = grid
    xs, ys = [x for x, _ in places], [y for _, y in places]
    x_low, x_high = origin[0] - min(xs), origin[0] + size[0] - 1 - max(xs)
    y_low, y_high = origin[1] - min(ys), origin[1] + size[1] - 1 - max(ys)
    blocked = {(u - x, v - y) for u, v in forbidden for x, y in places}
    queue = [(_remaining(start, goals), 0, 0, start)]
    came_from: dict[Cell, Cell] = {}
    best = {start: 0}
    pushed = 0
    while queue:
        _, cost, _, at = heapq.heappop(queue)
        if at in goals:
            return _trace(came_from, start, at)
        if -cost > best[at]:
            continue
        for move in MOVES:
            dx, dy = move.offset
            after = (at[0] + dx, at[1] + dy)
            inside = x_low <= after[0] <= x_high and y_low <= after[1] <= y_high
            if not inside or after in blocked or best[at] + 1 >= best.get(after, best[at] + 2):
                continue
            best[after] = best[at] + 1
            came_from[after] = at
            pushed += 1
            # Of equally good ends of ways, the one that came farthest; then the last found.
            heapq.heappush(queue, (best[after] + _remaining(after, goals), -best[after], -pushed, after))
    return None


def _remaining(at: Cell, goals: Collection[Cell]) -> int:
    return min(abs(at[0] - x) + abs(at[1] - y) for x, y in goals)


def _trace(came_from: dict[Cell, Cell], start: Cell, end: Cell) -> list[Cell]:
    path = []
    while end != start:
        path.append(end)
        end = came_from[end]
    return path[::-1]
