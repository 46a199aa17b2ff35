"""Was this assembly legal, and is the structure complete? Judged from where the boats were, not from what was planned.

The judge knows the problem, how the boats were turned, and their cells step by step. It finds out by itself what
docked: neighboring sides that join, dock as soon as they meet and hold to the end (section 5 of the digest).
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from swarm_msgs_py.assembly.faces import OFFSETS, Cell, Face, Layout, turned
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import CLEARANCE, AssemblyProblem
from swarm_msgs_py.types import IntArray

Pair = tuple[int, int]
Group = frozenset[int]

_STEP_OF = {offset: Face(number) for number, offset in enumerate(OFFSETS)}


@dataclass(frozen=True, slots=True)
class AssemblyAudit:
    """What came out.

    Attributes
    ----------
    steps : int
        Steps until the last boat that was dispatched came to rest.
    violations : tuple of str
        Broken rules in order of time, one line each; empty if the assembly was legal and complete.
    docked_contacts : int
        Docked pairs of boats in the end.
    components : int
        Docked groups among the dispatched boats in the end; 1 if the structure holds together.
    dockings : int
        Events in which two groups joined.
    """

    steps: int
    violations: tuple[str, ...]
    docked_contacts: int
    components: int
    dockings: int

    @property
    def is_legal_and_complete(self) -> bool:
        """Whether the structure stands, and no rule was broken on the way."""
        return not self.violations


@dataclass(slots=True)
class _Judge:
    """Follows the boats from step to step."""

    problem: AssemblyProblem
    dispatch: Dispatch
    layouts: list[Layout]
    target_of: dict[int, int]
    violations: list[str] = field(default_factory=list)
    docked: set[Pair] = field(default_factory=set)
    groups: list[Group] = field(default_factory=list)  # group of each boat
    joined: dict[Group, Group] = field(default_factory=dict)  # what a group joined when it docked
    close: dict[tuple[Group, Group], int] = field(default_factory=dict)  # first step at which two groups were close
    dockings: int = 0

    def look(self, step: int, cells: IntArray, before: IntArray) -> None:
        """Judge one step."""
        self._check_moves(step, cells, before)
        near = sorted(tuple(sorted(p)) for p in cKDTree(cells).query_pairs(CLEARANCE - 0.5, p=np.inf))
        fresh = []
        for one, other in near:
            offset = (int(cells[other, 0] - cells[one, 0]), int(cells[other, 1] - cells[one, 1]))
            if offset == (0, 0):
                self._blame(step, f"boats {one} and {other} are both at {_cell(cells[one])}")
            elif (one, other) not in self.docked and self._joins(one, other, offset):
                fresh.append((one, other))
                self._check_wanted(step, one, other, offset)
        for one, other in sorted(self.docked):
            if tuple(cells[other] - cells[one]) != tuple(before[other] - before[one]):
                self._blame(step, f"boats {one} and {other} were docked and came apart")
        self._join(step, fresh)
        for one, other in near:
            pair = self.groups[one], self.groups[other]
            if pair[0] != pair[1]:
                self.close.setdefault(pair, step)

    def finish(self, cells: IntArray) -> None:
        """Judge what stands in the end, and whom groups came close to on the way."""
        for (one, other), step in self.close.items():
            if self.joined.get(one) != other or self.joined.get(other) != one:
                self._blame(
                    step, f"groups of boats {min(one)} and {min(other)} are closer than a cell, and do not join"
                )
        for boat, target in sorted(self.target_of.items()):
            if _cell(cells[boat]) != self.problem.targets[target]:
                self._blame(None, f"boat {boat} ends at {_cell(cells[boat])}, not at {self.problem.targets[target]}")
        if self.components() > 1:
            self._blame(None, f"the structure has {self.components()} pieces that are not docked")

    def components(self) -> int:
        """Return the docked groups among the dispatched boats."""
        return len({self.groups[boat] for boat in self.target_of})

    def _blame(self, step: int | None, what: str) -> None:
        self.violations.append(f"end: {what}" if step is None else f"step {step}: {what}")

    def _check_moves(self, step: int, cells: IntArray, before: IntArray) -> None:
        lengths = np.abs(cells - before).sum(axis=1)
        for boat in np.flatnonzero(lengths > 1).tolist():
            self._blame(step, f"boat {boat} makes {lengths[boat]} moves at once")
        for boat in np.flatnonzero(lengths).tolist():
            if boat not in self.target_of:
                self._blame(step, f"boat {boat} moves, and has no target")
        for boat, cell in enumerate(map(_cell, cells)):
            if not self.problem.contains(cell):
                self._blame(step, f"boat {boat} leaves the grid at {cell}")
        was = {_cell(cell): boat for boat, cell in enumerate(before)}
        for boat in np.flatnonzero(lengths).tolist():
            other = was.get(_cell(cells[boat]), boat)
            if other > boat and _cell(cells[other]) == _cell(before[boat]):
                self._blame(step, f"boats {boat} and {other} swap cells")

    def _joins(self, one: int, other: int, offset: Cell) -> bool:
        face = _STEP_OF.get(offset)
        if face is None:
            return False
        return self.problem.gender.joins(self.layouts[one][face], self.layouts[other][face.opposite])

    def _check_wanted(self, step: int, one: int, other: int, offset: Cell) -> None:
        ends = [self.target_of.get(boat) for boat in (one, other)]
        if ends[0] is not None and ends[1] is not None:
            (x, y), (u, v) = self.problem.targets[ends[0]], self.problem.targets[ends[1]]
            if (u - x, v - y) == offset:
                return
        self._blame(step, f"boats {one} and {other} dock where the structure has no such neighbors")

    def _join(self, step: int, fresh: list[Pair]) -> None:
        """Note new docks, and the groups that follow from them."""
        if not fresh:
            return
        self.docked.update(fresh)
        count = len(self.layouts)
        pairs = np.array(sorted(self.docked))
        graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
        _, labels = connected_components(graph, directed=False)
        boats: dict[int, list[int]] = defaultdict(list)
        for boat, label in enumerate(labels.tolist()):
            boats[label].append(boat)
        for one in boats.values():
            parts = sorted({self.groups[boat] for boat in one}, key=min)
            if len(parts) == 1:
                continue
            self.dockings += 1
            if len(parts) > 2:
                self._blame(step, f"{len(parts)} groups dock at once, around boat {one[0]}")
            self.joined[parts[0]], self.joined[parts[1]] = parts[1], parts[0]
            for boat in one:
                self.groups[boat] = frozenset(one)


def audit_assembly(problem: AssemblyProblem, dispatch: Dispatch, cells: IntArray) -> AssemblyAudit:
    """Return what came of an assembly, and every rule that it broke.

    Parameters
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
        Who was to go where; boats keep these orientations from the start.
    cells : (steps + 1, n, 2) int array
        Cell of every boat, the start first.
    """
    target_of = {boat: target for target, boat in enumerate(dispatch.boats)}
    turns = {boat: dispatch.turns[target] for boat, target in target_of.items()}
    layouts = [turned(layout, turns.get(boat, 0)) for boat, layout in enumerate(problem.layouts)]
    judge = _Judge(problem, dispatch, layouts, target_of)
    judge.groups = [frozenset({boat}) for boat in range(problem.boat_count)]
    if [_cell(cell) for cell in cells[0]] != list(problem.starts):
        judge.violations.append("step 0: boats do not begin at their starts")
    for step in range(len(cells)):
        judge.look(step, cells[step], cells[max(step - 1, 0)])
    judge.finish(cells[-1])
    moving = np.flatnonzero((np.diff(cells, axis=0) != 0).any(axis=(1, 2)))
    return AssemblyAudit(
        steps=int(moving[-1]) + 1 if len(moving) else 0,
        violations=tuple(judge.violations),
        docked_contacts=len(judge.docked),
        components=judge.components(),
        dockings=judge.dockings,
    )


def _cell(row: IntArray) -> Cell:
    return int(row[0]), int(row[1])
