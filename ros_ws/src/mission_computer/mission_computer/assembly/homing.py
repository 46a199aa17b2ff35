"""Boats, and groups that cannot come apart, from where the structure left them to their starts.

Prioritized planning in space and time: groups are planned one after the other around the paths of those before. For one
group, all places that it can have reached are known layer by layer, one layer per step, so the arrival is the earliest
there is and a failure is a proof. A group that finds no way, or arrives last, is planned first in the next attempt. Who
is still to be planned must be able to get away from where it is: the others keep clear of that for some steps, how many
varies with the attempt.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.assembly.faces import OFFSETS, Cell
from swarm_msgs_py.assembly.problem import CLEARANCE, AssemblyProblem, manhattan
from swarm_msgs_py.types import BoolArray, IntArray

PATIENCE_STEPS = (0, 2, 1, 4)
"""For how long boats keep clear of where boats of lower priority begin, tried in turn."""

REACH = CLEARANCE - 1
"""Cells around a boat that others may not enter, along each axis."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HomingLimits:
    """Bounds of the search.

    Attributes
    ----------
    attempts : int
        Orders of priority that are tried.
    detour : int
        Steps beyond the longest straight way that a boat may take.
    keeps_order : bool
        Whether nobody comes to where one of higher priority still was in the step before; then no ring of groups moves
        up within one step (see `Manner.keeps_order`).
    """

    attempts: int = 40
    detour: int = 40
    keeps_order: bool = False


class SpaceTime:
    """Cells that are free at each step.

    Parameters
    ----------
    problem : AssemblyProblem
        Its grid is used.
    obstacles : sequence of Cell
        Boats that never move.
    steps : int
        Last step that is looked at.
    """

    def __init__(self, problem: AssemblyProblem, obstacles: Sequence[Cell], steps: int) -> None:
        columns, rows = problem.size
        self._origin = problem.origin
        # A border of one cell all around, so that a step off the grid lands on a cell that is never free.
        still = np.ones((columns + 2, rows + 2), dtype=np.bool_)
        still[1:-1, 1:-1] = False
        for cell in obstacles:
            x, y = self._index(cell)
            still[x - REACH : x + REACH + 1, y - REACH : y + REACH + 1] = True
        self._taken: BoolArray = np.repeat(still[None], steps + 1, axis=0)
        # A boat that was stopped may be where it stopped, however near an obstacle is: only boats can take its goal.
        self._by_boats: BoolArray | None = np.zeros_like(self._taken) if problem.is_midway else None
        self._steps = steps

    def earliest(
        self,
        start: Cell,
        goal: Cell,
        waiting: Sequence[Cell] = (),
        patience: int = 0,
        crew: Sequence[Cell] = ((0, 0),),
    ) -> IntArray | None:
        """Return the path that reaches `goal` first and may stay there, (k, 2) cells; None if there is none.

        For the first `patience` steps it keeps clear of the `waiting` cells. A group is at `crew`, relative to its
        path.
        """
        if len(crew) > 1:
            return self._for_crew(crew).earliest(start, goal, self._around(waiting, crew), patience)
        if self._by_boats is not None:
            column = (slice(None), *self._index(goal))
            other = copy(self)
            other._taken, other._by_boats = self._taken.copy(), None
            other._taken[column] = self._by_boats[column]
            return other.earliest(start, goal, waiting, patience)
        held = np.zeros_like(self._taken[0])
        for cell in waiting:
            x, y = self._index(cell)
            held[x - REACH : x + REACH + 1, y - REACH : y + REACH + 1] = True
        layers, arrival = self._flood(start, goal, [held] * patience)
        if arrival is None:
            return None
        at = self._index(goal)
        path = [at]
        last = (0, 0)
        for layer in reversed(layers[:arrival]):
            steps = [last, (0, 0), *OFFSETS]  # straight on, if that is a way too
            last = next(step for step in steps if layer[at[0] - step[0], at[1] - step[1]])
            at = (at[0] - last[0], at[1] - last[1])
            path.append(at)
        shift = np.array([self._origin[0] - 1, self._origin[1] - 1])
        cells: IntArray = np.array(path[::-1], dtype=np.int64) + shift
        return cells

    def _for_crew(self, crew: Sequence[Cell]) -> SpaceTime:
        """Return the space in which a group is a point: taken where any of its boats would be in the way."""
        other = copy(self)
        other._taken = _for_any(self._taken, crew)
        other._by_boats = None if self._by_boats is None else _for_any(self._by_boats, crew)
        return other

    def _around(self, cells: Sequence[Cell], crew: Sequence[Cell]) -> list[Cell]:
        """Return where a group may not be lest one of its boats is at one of `cells`, in the grid."""
        columns, rows = self._taken.shape[1:]
        found = {(x - dx, y - dy) for x, y in cells for dx, dy in crew}
        return [
            c
            for c in sorted(found)
            if all(1 <= i < n - 1 for i, n in zip(self._index(c), (columns, rows), strict=True))
        ]

    def reserve(self, path: IntArray, *, lingers: bool = False) -> None:
        """Take a path's cells and what is too near to them, the last one to the end.

        What lingers is taken for one more step each. Boats that were stopped side by side may both be where they
        stopped, so that a boat that is there for good takes no more than its cell from the goals of others.
        """
        steps = np.arange(self._steps + 1)
        here = path[np.minimum(steps, len(path) - 1)] - np.array(self._origin) + 1
        self._take(self._taken, steps, here, REACH, lingers=lingers)
        if self._by_boats is not None:
            comes = steps < len(path) - 1
            self._take(self._by_boats, steps[comes], here[comes], REACH, lingers=lingers)
            self._take(self._by_boats, steps[~comes], here[~comes], 0, lingers=False)

    @staticmethod
    def _take(taken: BoolArray, steps: IntArray, cells: IntArray, reach: int, *, lingers: bool) -> None:
        for dx in range(-reach, reach + 1):
            for dy in range(-reach, reach + 1):
                x, y = (cells + np.array([dx, dy])).T
                taken[steps, x, y] = True
                if lingers:
                    after = steps[:-1] + 1
                    taken[after, x[: len(after)], y[: len(after)]] = True

    def _index(self, cell: Cell) -> Cell:
        return cell[0] - self._origin[0] + 1, cell[1] - self._origin[1] + 1

    def _flood(self, start: Cell, goal: Cell, held: Sequence[BoolArray]) -> tuple[list[BoolArray], int | None]:
        """Return the cells reached at each step, and the step at which the goal is reached for good."""
        gx, gy = self._index(goal)
        blocked = np.flatnonzero(self._taken[:, gx, gy])
        settled = int(blocked[-1]) + 1 if len(blocked) else 0
        reached: BoolArray = np.zeros(self._taken.shape[1:], dtype=np.bool_)
        reached[self._index(start)] = not self._taken[(0, *self._index(start))]
        layers = [reached]
        for step in range(self._steps + 1):
            if step >= settled and reached[gx, gy]:
                return layers, step
            if step == self._steps:
                break
            spread = reached.copy()
            spread[1:] |= reached[:-1]
            spread[:-1] |= reached[1:]
            spread[:, 1:] |= reached[:, :-1]
            spread[:, :-1] |= reached[:, 1:]
            spread &= ~self._taken[step + 1]
            if step < len(held):
                spread &= ~held[step]
            if not spread.any():
                break
            reached = spread
            layers.append(reached)
        return layers, None


def plan_homing(  # noqa: PLR0913, PLR0917 - a whole problem of its own
    problem: AssemblyProblem,
    obstacles: Sequence[Cell],
    here: Sequence[Cell],
    goals: Sequence[Cell],
    limits: HomingLimits,
    groups: Sequence[Sequence[int]] = (),
) -> IntArray | None:
    """Return paths of boats to their goals, keeping clear of each other.

    Parameters
    ----------
    problem : AssemblyProblem
        Its grid is used.
    obstacles : sequence of Cell
        Boats that never move.
    here, goals : sequence of Cell
        Where each boat is, pairwise clear of the others, and where it goes.
    limits : HomingLimits
    groups : sequence of sequence of int
        Boats that move as one; every other boat is a group of its own.

    Returns
    -------
    (steps + 1, n, 2) int array or None
        Cells of all boats per step; the best of all attempts. None if no attempt brought all boats home.
    """
    grouped = {boat for group in groups for boat in group}
    crews = [tuple(group) for group in groups] + [(boat,) for boat in range(len(here)) if boat not in grouped]
    ways = [manhattan(here[crew[0]], goals[crew[0]]) for crew in crews]
    order = sorted(range(len(crews)), key=lambda crew: (-ways[crew], crews[crew]))
    horizon = max(ways, default=0) + limits.detour
    best: IntArray | None = None
    for attempt in range(limits.attempts):
        space = SpaceTime(problem, obstacles, horizon)
        patience = PATIENCE_STEPS[attempt % len(PATIENCE_STEPS)]
        paths: dict[int, IntArray] = {}
        for place, number in enumerate(order):
            crew = crews[number]
            waiting = [here[boat] for other in order[place + 1 :] for boat in crews[other]] if patience else []
            offsets = [(here[boat][0] - here[crew[0]][0], here[boat][1] - here[crew[0]][1]) for boat in crew]
            path = space.earliest(here[crew[0]], goals[crew[0]], waiting, patience, offsets)
            if path is None:
                break
            for boat, offset in zip(crew, offsets, strict=True):
                paths[boat] = path + np.array(offset)
            for boat in crew:
                space.reserve(paths[boat], lingers=limits.keeps_order)
        done = next((place for place, number in enumerate(order) if crews[number][0] not in paths), len(order))
        late = order[done] if done < len(order) else max(order, key=lambda number: len(paths[crews[number][0]]))
        if done == len(order):
            steps = max((len(path) for path in paths.values()), default=1) - 1
            if best is None or steps < len(best) - 1:
                best = _stacked(paths, steps)
                horizon = max(steps - 1, 0)  # only a better plan is of interest from here on
            if steps == max(ways, default=0):
                return best
        order.remove(late)
        order.insert(0, late)
    return best


def _for_any(taken: BoolArray, crew: Sequence[Cell]) -> BoolArray:
    """Return where any boat of a crew would be at a cell that is taken, or off the grid."""
    columns, rows = taken.shape[1:]
    found: BoolArray = np.zeros_like(taken)
    for dx, dy in crew:
        moved = np.ones_like(taken)
        moved[:, max(0, -dx) : columns - max(0, dx), max(0, -dy) : rows - max(0, dy)] = taken[
            :, max(0, dx) : columns - max(0, -dx), max(0, dy) : rows - max(0, -dy)
        ]
        found |= moved
    return found


def _stacked(paths: dict[int, IntArray], steps: int) -> IntArray:
    rows = [
        np.concatenate([paths[boat], np.repeat(paths[boat][-1:], steps + 1 - len(paths[boat]), axis=0)])
        for boat in sorted(paths)
    ]
    return np.stack(rows, axis=1)
