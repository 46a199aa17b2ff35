"""Dispatch as a constraint program: assignment, orientations, docked contacts and a tree of cuts in one model.

Boats whose layouts are turns of one another form a *class*. The model knows which boat takes which target (only pairs
within a travel bound) and which turned layout stands on each target; for each target and class both must agree. Turning
is free, so boats of a class need no variables for orientations of their own.

The tree of cuts is part of the model: a part that is used is cut by a line that at least one docked contact crosses,
and both its parts are used. Connectivity follows from that, so the model needs no flow, and when the solver proves it
infeasible there is no dispatch that can be put together pairwise along straight lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ortools.sat.python import cp_model

from mission_computer.assembly.structure import Part, Structure
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.faces import Layout, distinct_turns, layout_class, turned
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem


@dataclass(frozen=True, slots=True)
class SolverLimits:
    """Work that the solver may do; deterministic units, so that equal problems give equal dispatches on any machine."""

    seed: int
    work: float


@dataclass(frozen=True, slots=True)
class Solution:
    """What the solver says: a dispatch, a proof that there is none, or neither within its limits."""

    dispatch: Dispatch | None
    is_proof: bool


class DispatchModel:
    """Constraint program for dispatches within a travel bound.

    Parameters
    ----------
    problem : AssemblyProblem
    structure : Structure
        Of the problem's targets.
    travel_max : int
        No boat travels farther than this [cells].
    """

    def __init__(self, problem: AssemblyProblem, structure: Structure, travel_max: int) -> None:
        self._problem = problem
        self._structure = structure
        self._model = cp_model.CpModel()
        self._takes: dict[tuple[int, int], cp_model.IntVar] = {}
        self._stands: list[dict[Layout, cp_model.IntVar]] = []
        self._docked: dict[Contact, cp_model.IntVar] = {}
        self._add_assignment(travel_max)
        self._add_layouts()
        for contact in structure.contacts if problem.target_count > 1 else ():
            self._add_contact(contact)
        self._used: dict[Part, cp_model.IntVar] = {}
        if not structure.is_atom(structure.whole):
            self._model.add(self._add_part(structure.whole) == 1)

    def minimize_travel(self) -> None:
        """Ask for the least total travel."""
        self._model.minimize(sum(self._problem.travel(*pair) * takes for pair, takes in self._takes.items()))

    def hint(self, dispatch: Dispatch) -> None:
        """Begin the search from a dispatch."""
        chosen = {(boat, target) for target, boat in enumerate(dispatch.boats)}
        for pair, takes in self._takes.items():
            self._model.add_hint(takes, pair in chosen)
        for stands, layout in zip(self._stands, dispatch.layouts(self._problem), strict=True):
            for turned_layout, variable in stands.items():
                self._model.add_hint(variable, turned_layout == layout)

    def solve(self, limits: SolverLimits) -> Solution:
        """Return a dispatch, or whether there is a proof that none exists."""
        solver = new_solver(limits)
        status = solver.solve(self._model)
        if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            return Solution(None, status == cp_model.INFEASIBLE)
        boats = [-1] * self._problem.target_count
        for (boat, target), takes in self._takes.items():
            if solver.boolean_value(takes):
                boats[target] = boat
        turns = []
        for boat, stands in zip(boats, self._stands, strict=True):
            wanted = next(layout for layout, variable in stands.items() if solver.boolean_value(variable))
            turns.append(turns_to(self._problem.layouts[boat], wanted))
        return Solution(Dispatch(tuple(boats), tuple(turns)), False)

    def _add_assignment(self, travel_max: int) -> None:
        problem, model = self._problem, self._model
        must_dock = problem.target_count > 1
        for boat, layout in enumerate(problem.layouts):
            if must_dock and not any(layout):
                continue
            near = [t for t in range(problem.target_count) if problem.travel(boat, t) <= travel_max]
            for target in near:
                self._takes[boat, target] = model.new_bool_var("")
            if near:
                model.add_at_most_one(self._takes[boat, target] for target in near)
        for target in range(problem.target_count):
            model.add_exactly_one(takes for (_, at), takes in self._takes.items() if at == target)

    def _add_layouts(self) -> None:
        """Let a turned layout of a class stand where, and only where, a boat of that class goes."""
        classes: dict[Layout, list[int]] = {}
        for boat, layout in enumerate(self._problem.layouts):
            classes.setdefault(layout_class(layout), []).append(boat)
        for target in range(self._problem.target_count):
            stands: dict[Layout, cp_model.IntVar] = {}
            for representative, boats in sorted(classes.items()):
                takers = [self._takes[boat, target] for boat in boats if (boat, target) in self._takes]
                if not takers:
                    continue
                turned_layouts = [turned(representative, turns) for turns in distinct_turns(representative)]
                variables = [self._model.new_bool_var("") for _ in turned_layouts]
                self._model.add(sum(takers) == sum(variables))
                stands.update(zip(turned_layouts, variables, strict=True))
            self._model.add_exactly_one(stands.values())
            self._stands.append(stands)

    def _add_contact(self, contact: Contact) -> None:
        """Let a contact be docked only if the sides that meet join."""
        sides = (contact.one, contact.face), (contact.other, contact.face.opposite)
        self._docked[contact] = add_dock(
            self._model,
            [
                tuple(
                    [variable for layout, variable in self._stands[target].items() if layout[face] == side]
                    for (target, face), side in zip(sides, pair, strict=True)
                )
                for pair in self._problem.gender.pairs
            ],
        )

    def _add_part(self, part: Part) -> cp_model.IntVar:
        """Return the variable that says whether a part of more than one cell is used."""
        if part in self._used:
            return self._used[part]
        used = self._used[part] = self._model.new_bool_var("")
        choices = []
        for cut in self._structure.cuts(part):
            if not (self._structure.is_connected(cut.low) and self._structure.is_connected(cut.high)):
                continue
            chosen = self._model.new_bool_var("")
            crossing = [self._docked[contact] for contact in self._structure.crossing(part, cut)]
            self._model.add_bool_or([*crossing, chosen.negated()])
            for side in (cut.low, cut.high):
                if not self._structure.is_atom(side):
                    self._model.add_implication(chosen, self._add_part(side))
            choices.append(chosen)
        self._model.add_bool_or([*choices, used.negated()])
        return used


def new_solver(limits: SolverLimits) -> cp_model.CpSolver:
    """Return a solver that does the same work for equal problems, on any machine."""
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.catch_sigint_signal = False  # it would leave the process without a handler of its own
    solver.parameters.random_seed = limits.seed
    solver.parameters.max_deterministic_time = limits.work
    return solver


def add_dock(model: cp_model.CpModel, ways: Sequence[Sequence[Sequence[cp_model.IntVar]]]) -> cp_model.IntVar:
    """Return a variable that may be true only if the sides that meet at a contact join.

    Parameters
    ----------
    model : CpModel
    ways : sequence of pairs of sequences of variables
        For each pair of sides that join: what brings the one to the contact, and what the other.
    """
    joined = []
    for pair in ways:
        way = model.new_bool_var("")
        for bringing in pair:
            model.add_bool_or([*bringing, way.negated()])
        joined.append(way)
    docked = model.new_bool_var("")
    model.add_bool_or([*joined, docked.negated()])
    return docked


def turns_to(layout: Layout, wanted: Layout) -> int:
    """Return the least clockwise quarter turns that take `layout` to `wanted`.

    Raises
    ------
    ValueError
        If no turn does.
    """
    for turns in distinct_turns(layout):
        if turned(layout, turns) == wanted:
            return turns
    raise ValueError(f"no turn takes {layout} to {wanted}")
