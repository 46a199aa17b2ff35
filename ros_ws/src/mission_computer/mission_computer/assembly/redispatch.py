"""Going on after a loss: what stands stays together, and free boats are dispatched anew.

If they are too few, the largest part of the structure is built that can be. If a dead boat is in the way, the structure
is built a few cells beside its place.

Docked groups keep their places in the structure, because their magnets hold for good. Every boat that floats alone may
take any place that is left, a spare one as well. Places are given up a few at a time, fewest first, until a dispatch
exists; what was lost is tried first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice

from mission_computer.assembly.constraint_model import DispatchModel, SolverLimits
from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.structure import Part, Structure, part_of
from mission_computer.assembly.timed_plan import TimedLimits, plan_timed_paths
from mission_computer.assembly.travel import travel_matrix
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import OFFSETS
from swarm_msgs_py.assembly.plan import AssemblyPlan, Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem, pieces
from swarm_msgs_py.errors import NoDispatchError

SOLVER_WORK = 2.0
"""Deterministic solver time for one choice of places."""
CHOICES_MAX = 60
"""Choices of places that are tried for each number of places given up."""
SHIFTS = ((0, 0), *((far * x, far * y) for far in (2, 4) for x, y in OFFSETS))
"""Where else the structure is built, relative to its place, if a dead boat is in the way there; tried in turn."""
GIVEN_UP_MAX = 4
"""Atoms that are given up at once before the search is content with the largest group that stands."""


@dataclass(frozen=True, slots=True)
class Midway:
    """An assembly that has stopped.

    Attributes
    ----------
    problem : AssemblyProblem
        Starts are where boats are now, layouts how they are turned and what still works on them.
    dispatch : Dispatch
        Who was to go where; turns do not count any more.
    groups : tuple of tuple of int
        Boats that are docked with each other, in groups of two or more.
    dead : frozenset of int
        Boats that move no more; in a group they are carried along.
    suspects : frozenset of int
        Boats on their own whose docks did not hold; others are preferred to them.
    """

    problem: AssemblyProblem
    dispatch: Dispatch
    groups: tuple[tuple[int, ...], ...]
    dead: frozenset[int]
    suspects: frozenset[int] = frozenset()


def plan_rest(midway: Midway, seed: int, limits: TimedLimits) -> tuple[AssemblyProblem, AssemblyPlan]:
    """Return what can still be built, and the plan of it.

    Returns
    -------
    problem : AssemblyProblem
        The places that are kept as targets, maybe all shifted alike; boats and starts as they are now.
    plan : AssemblyPlan
        With timed paths.

    Raises
    ------
    NoDispatchError
        If nothing can be added to what stands.
    """
    problem = _without_lone_dead(midway)
    target_of = {boat: target for target, boat in enumerate(midway.dispatch.boats)}
    groups = [group for group in midway.groups if all(boat in target_of for boat in group)]
    for kept in _choices(midway, groups, target_of):
        places = {target: number for number, target in enumerate(kept)}
        smaller = replace(problem, targets=tuple(problem.targets[target] for target in kept))
        stands = [group for group in groups if target_of[group[0]] in places]
        fixed = {boat: places[target_of[boat]] for group in stands for boat in group}
        atoms = [part_of(fixed[boat] for boat in group) for group in stands]
        left_out = {boat for group in groups if group not in stands for boat in group}
        for unwanted in dict.fromkeys((midway.suspects - set(fixed), frozenset())):
            found = _dispatch(smaller, Structure(smaller.targets, atoms), fixed, left_out | unwanted, seed)
            if found is None:
                continue
            for shifted in _beside(smaller):
                plan = _moves(shifted, found, atoms, seed, limits)
                if plan is not None:
                    return shifted, plan
    raise NoDispatchError(f"{problem.name}: nothing can be added to what stands with the boats that are left")


def _beside(problem: AssemblyProblem) -> Iterator[AssemblyProblem]:
    """Yield the problem, and the same with its targets shifted, as far as that fits the grid."""
    for dx, dy in SHIFTS:
        targets = tuple((x + dx, y + dy) for x, y in problem.targets)
        if all(problem.contains(cell) for cell in targets):
            yield replace(problem, targets=targets)


def _without_lone_dead(midway: Midway) -> AssemblyProblem:
    """Return the problem in which dead boats that float alone can dock with nobody."""
    docked = {boat for group in midway.groups for boat in group}
    layouts = list(midway.problem.layouts)
    for boat in midway.dead - docked:
        layouts[boat] = (0, 0, 0, 0)
    return replace(midway.problem, layouts=tuple(layouts), is_midway=True)


def _choices(midway: Midway, groups: Sequence[tuple[int, ...]], target_of: dict[int, int]) -> Iterator[tuple[int, ...]]:
    """Yield the targets to keep, most first; of equally many, those without what the lost boats were to fill."""
    cells = midway.problem.targets
    atoms = [tuple(target_of[boat] for boat in group) for group in groups]
    taken = {target for atom in atoms for target in atom}
    atoms += [(target,) for target in range(len(cells)) if target not in taken]
    lost = {target_of[boat] for boat in midway.dead if boat in target_of}
    sizes: dict[int, list[tuple[int, ...]]] = {}
    for number in range(GIVEN_UP_MAX + 1):
        for given_up in combinations(range(len(atoms)), number):
            gone = {target for index in given_up for target in atoms[index]}
            kept = tuple(target for target in range(len(cells)) if target not in gone)
            if kept and len(pieces(cells[target] for target in kept)) == 1:
                sizes.setdefault(len(kept), []).append(kept)
    for size in sorted(sizes, reverse=True):
        ranked = sorted(sizes[size], key=lambda kept: len(lost.intersection(kept)))
        yield from islice(ranked, CHOICES_MAX)


def _dispatch(
    problem: AssemblyProblem, structure: Structure, fixed: dict[int, int], left_out: set[int], seed: int
) -> Dispatch | None:
    """Return a short dispatch in which docked boats keep their places, None if there is none."""
    free = [boat for boat in range(problem.boat_count) if boat not in fixed and boat not in left_out]
    if sum(any(problem.layouts[boat]) for boat in free) < problem.target_count - len(fixed):
        return None
    usable = tuple(layout if boat not in left_out else (0, 0, 0, 0) for boat, layout in enumerate(problem.layouts))
    problem = replace(problem, layouts=usable)
    model = DispatchModel(problem, structure, int(travel_matrix(problem).max()))
    for boat, target in fixed.items():
        model.fix(boat, target)
    model.minimize_travel()
    return model.solve(SolverLimits(seed, SOLVER_WORK)).dispatch


def _moves(
    problem: AssemblyProblem, dispatch: Dispatch, atoms: Sequence[Part], seed: int, limits: TimedLimits
) -> AssemblyPlan | None:
    structure = Structure(problem.targets, atoms)
    docked = docked_contacts(problem.targets, dispatch.layouts(problem), problem.gender)
    timed = plan_timed_paths(problem, dispatch, CutForest(structure, docked), seed, limits)
    return None if timed is None else AssemblyPlan(dispatch, timed.tree, None, timed.paths, 1)
