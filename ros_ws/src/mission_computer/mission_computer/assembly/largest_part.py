"""The largest part of a structure that the boats that are left can be put together to, by a constraint program.

Docked groups are rigid and do not turn, but may go wherever their shape fits; every other boat may take any place,
turned as it likes. Which places are filled is a question of the model, and so is the tree of cuts: a rectangle of the
structure holds together if a line has docked contacts across and both its sides hold together, if a line has nobody on
one side and the other holds together, or if one boat or one group is all there is. When the solver ends with a proof,
no larger part can be put together pairwise along straight lines.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from ortools.sat.python import cp_model
from scipy.optimize import linear_sum_assignment

from mission_computer.assembly.constraint_model import SolverLimits, add_dock, new_solver, turns_to
from mission_computer.assembly.structure import Cut, Part, Structure, members, part_of
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.faces import Layout, distinct_turns, layout_class, turned
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem

SUSPECT = 1000
"""Cells of travel that it is worth not to use a boat whose docks failed."""
TRAVEL_SHARE = 0.3
"""Of the work, for making the travel short once it is known how large the part can be."""

Crew = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class BuildablePart:
    """A part of the structure, and who goes where in it.

    Attributes
    ----------
    targets : tuple of int
        Places that are filled, ascending.
    dispatch : Dispatch
        For these places in their order.
    groups : tuple of Crew
        Docked groups that go into it.
    bound : int
        No part of more places can be put together: the size of this one, if it is proven to be the largest.
    """

    targets: tuple[int, ...]
    dispatch: Dispatch
    groups: tuple[Crew, ...]
    bound: int


@dataclass(frozen=True, slots=True)
class _Placement:
    """A docked group somewhere in the structure: the target of each of its boats, and how far that is [cells]."""

    crew: Crew
    targets: tuple[int, ...]
    travel: int


def largest_part(
    problem: AssemblyProblem,
    groups: Sequence[Crew],
    suspects: Collection[int],
    forbidden: Iterable[BuildablePart],
    limits: SolverLimits,
) -> BuildablePart | None:
    """Return the largest part that can be built, other than those forbidden; None if there is none or none was found.

    Of equally large parts it is one without suspects, if there is one, and for which boats travel little.

    Parameters
    ----------
    problem : AssemblyProblem
        Starts are where boats are now; boats that can dock with nobody have no mechanisms.
    groups : sequence of Crew
        Boats that are docked with each other.
    suspects : collection of int
        Boats on their own whose docks did not hold.
    forbidden : iterable of BuildablePart
        To which nobody found a way to move the boats.
    limits : SolverLimits
    """
    model = _PartModel(problem, groups, suspects)
    for part in forbidden:
        model.forbid(part)
    return model.solve(limits)


class _PartModel:
    def __init__(self, problem: AssemblyProblem, groups: Sequence[Crew], suspects: Collection[int]) -> None:
        self._problem, self._suspects = problem, frozenset(suspects)
        self._structure = Structure(problem.targets)
        self._model = cp_model.CpModel()
        docked = {boat for group in groups for boat in group}
        self._classes: dict[Layout, list[int]] = {}
        for boat, layout in enumerate(problem.layouts):
            if boat not in docked and any(layout):
                self._classes.setdefault(layout_class(layout), []).append(boat)
        self._placed: dict[_Placement, cp_model.IntVar] = {}
        for group in groups:
            fits = {placement: self._model.new_bool_var("") for placement in self._placements(group)}
            self._model.add_at_most_one(fits.values())
            self._placed |= fits
        turns = {turned(one, n): one for one in sorted(self._classes) for n in distinct_turns(one)}
        self._stands = [{layout: self._model.new_bool_var("") for layout in turns} for _ in problem.targets]
        for one, boats in self._classes.items():
            layouts = [layout for layout, representative in turns.items() if representative == one]
            self._model.add(sum(stands[layout] for stands in self._stands for layout in layouts) <= len(boats))
        self._takes: dict[tuple[int, int], cp_model.IntVar] = {}
        self._filled = [self._add_target(target) for target in range(problem.target_count)]
        self._docked = {contact: self._add_contact(contact) for contact in self._structure.contacts}
        self._joined: dict[Part, cp_model.IntVar] = {}
        self._emptied: dict[Part, cp_model.IntVar] = {}
        self._alone: dict[Part, list[_Placement]] = {}
        for placement in self._placed:
            self._alone.setdefault(self._rectangle(placement.targets), []).append(placement)
        self._model.add(self._joins(self._structure.whole) == 1)

    def forbid(self, part: BuildablePart) -> None:
        at = dict(zip(part.targets, part.dispatch.boats, strict=True))
        literals = [filled.negated() if target in at else filled for target, filled in enumerate(self._filled)]
        for one, placed in self._placed.items():
            literals.append(placed.negated() if self._is_so(one, at) else placed)
        self._model.add_bool_or(literals)

    def solve(self, limits: SolverLimits) -> BuildablePart | None:
        size = sum(self._filled)
        self._model.maximize(size)
        solver = new_solver(limits)
        if solver.solve(self._model) not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            return None
        found = self._part(solver, round(solver.best_objective_bound))
        self._model.add(size >= len(found.targets))
        self._model.minimize(self._cost())
        self._hint(found)
        nearer = new_solver(SolverLimits(limits.seed, TRAVEL_SHARE * limits.work))
        if nearer.solve(self._model) in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            found = self._part(nearer, found.bound)
        return found

    def _cost(self) -> cp_model.LinearExpr:
        """Return the travel of all boats [cells], and what is to be paid for suspects; adds who goes where."""
        costs = [placement.travel * placed for placement, placed in self._placed.items()]
        for one, boats in self._classes.items():
            self._takes |= {
                (boat, target): self._model.new_bool_var("") for boat in boats for target in range(len(self._filled))
            }
            for boat in boats:
                self._model.add_at_most_one(self._takes[boat, target] for target in range(len(self._filled)))
            for target, stands in enumerate(self._stands):
                turned_so = [variable for layout, variable in stands.items() if layout_class(layout) == one]
                self._model.add(sum(self._takes[boat, target] for boat in boats) == sum(turned_so))
        costs += [
            (self._problem.travel(*pair) + SUSPECT * (pair[0] in self._suspects)) * takes
            for pair, takes in self._takes.items()
        ]
        return cp_model.LinearExpr.sum(costs)

    def _hint(self, part: BuildablePart) -> None:
        """Begin the search from a part."""
        at = dict(zip(part.targets, part.dispatch.boats, strict=True))
        layouts = dict(zip(part.targets, part.dispatch.layouts(self._problem), strict=True))
        for (boat, target), takes in self._takes.items():
            self._model.add_hint(takes, at.get(target) == boat)
        for placement, placed in self._placed.items():
            self._model.add_hint(placed, self._is_so(placement, at))
        lone = {boat for boats in self._classes.values() for boat in boats}
        for target, stands in enumerate(self._stands):
            for layout, variable in stands.items():
                self._model.add_hint(variable, at.get(target) in lone and layouts.get(target) == layout)

    @staticmethod
    def _is_so(placement: _Placement, at: Mapping[int, int]) -> bool:
        return all(at.get(target) == boat for target, boat in zip(placement.targets, placement.crew, strict=True))

    def _placements(self, group: Crew) -> Iterable[_Placement]:
        """Yield every place in the structure that a group fits into, without a turn."""
        number = {cell: target for target, cell in enumerate(self._problem.targets)}
        starts = [self._problem.starts[boat] for boat in group]
        (x, y), *_ = starts
        for u, v in self._problem.targets:
            cells = [(a + u - x, b + v - y) for a, b in starts]
            if all(cell in number for cell in cells):
                travel = len(group) * (abs(u - x) + abs(v - y))
                yield _Placement(group, tuple(number[cell] for cell in cells), travel)

    def _add_target(self, target: int) -> cp_model.IntVar:
        filled = self._model.new_bool_var("")
        takers = [placed for placement, placed in self._placed.items() if target in placement.targets]
        self._model.add(sum([*takers, *self._stands[target].values()]) == filled)
        return filled

    def _add_contact(self, contact: Contact) -> cp_model.IntVar:
        def equipped(target: int, face: int, side: int) -> list[cp_model.IntVar]:
            lone = [variable for layout, variable in self._stands[target].items() if layout[face] == side]
            return lone + [
                placed
                for placement, placed in self._placed.items()
                for boat, at in zip(placement.crew, placement.targets, strict=True)
                if at == target and self._problem.layouts[boat][face] == side
            ]

        one, other = (contact.one, contact.face), (contact.other, contact.face.opposite)
        ways = [(equipped(*one, a), equipped(*other, b)) for a, b in self._problem.gender.pairs]
        return add_dock(self._model, ways)

    def _rectangle(self, targets: Sequence[int]) -> Part:
        """Return all places in the rectangle around some."""
        cells = np.array(self._problem.targets)
        low, high = cells[list(targets)].min(axis=0), cells[list(targets)].max(axis=0)
        return part_of(np.flatnonzero(((cells >= low) & (cells <= high)).all(axis=1)).tolist())

    def _is_empty(self, part: Part) -> cp_model.IntVar:
        if part not in self._emptied:
            empty = self._emptied[part] = self._model.new_bool_var("")
            for target in members(part):
                self._model.add_implication(empty, self._filled[target].negated())
        return self._emptied[part]

    def _joins(self, part: Part) -> cp_model.IntVar:
        """Return the variable that says that who stands in a part holds together."""
        if part in self._joined:
            return self._joined[part]
        joined = self._joined[part] = self._model.new_bool_var("")
        choices: list[cp_model.IntVar] = []
        if part & (part - 1) == 0:
            choices += self._stands[members(part)[0]].values()
        for placement in self._alone.get(part, ()):
            alone = self._model.new_bool_var("")
            self._model.add_implication(alone, self._placed[placement])
            self._model.add_implication(alone, self._is_empty(part & ~part_of(placement.targets)))
            choices.append(alone)
        for cut in self._structure.cuts(part):
            choices += self._cuts(part, cut)
        self._model.add_bool_or([*choices, joined.negated()])
        return joined

    def _cuts(self, part: Part, cut: Cut) -> list[cp_model.IntVar]:
        """Return the ways in which a line divides a part: two sides that hold together and dock, or one and nobody."""
        low, high = self._joins(cut.low), self._joins(cut.high)
        both, only_low, only_high = (self._model.new_bool_var("") for _ in range(3))
        for way, sides in (
            (both, (low, high)),
            (only_low, (low, self._is_empty(cut.high))),
            (only_high, (high, self._is_empty(cut.low))),
        ):
            for side in sides:
                self._model.add_implication(way, side)
        crossing = [self._docked[contact] for contact in self._structure.crossing(part, cut)]
        self._model.add_bool_or([*crossing, both.negated()])
        for placement, placed in self._placed.items():
            covered = part_of(placement.targets)
            if covered & cut.low and covered & cut.high:
                self._model.add_implication(both, placed.negated())
        return [both, only_low, only_high]

    def _part(self, solver: cp_model.CpSolver, bound: int) -> BuildablePart:
        """Return what the solver found; which boats of a class go where is an assignment problem."""
        problem = self._problem
        boat_at: dict[int, int] = {}
        groups = [placement for placement, placed in self._placed.items() if solver.boolean_value(placed)]
        for placement in groups:
            boat_at |= dict(zip(placement.targets, placement.crew, strict=True))
        turns = dict.fromkeys(boat_at, 0)
        standing = {
            target: layout
            for target, stands in enumerate(self._stands)
            for layout, variable in stands.items()
            if solver.boolean_value(variable)
        }
        for one, boats in self._classes.items():
            targets = [target for target, layout in standing.items() if layout_class(layout) == one]
            costs = [
                [problem.travel(boat, target) ** 2 + SUSPECT**2 * (boat in self._suspects) for target in targets]
                for boat in boats
            ]
            rows, columns = linear_sum_assignment(np.array(costs, dtype=np.float64).reshape(len(boats), -1))
            for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
                boat_at[targets[column]] = boats[row]
        turns |= {target: turns_to(problem.layouts[boat_at[target]], layout) for target, layout in standing.items()}
        kept = tuple(sorted(boat_at))
        dispatch = Dispatch(tuple(boat_at[target] for target in kept), tuple(turns[target] for target in kept))
        return BuildablePart(kept, dispatch, tuple(placement.crew for placement in groups), bound)
