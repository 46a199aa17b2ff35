"""Going on after a loss: what stands stays together, and the largest part that can be built is planned.

Docked groups are rigid, because their magnets hold for good, and go wherever they fit. Every boat that floats alone may
take any place, a spare one as well. If a dead boat is in the way, the structure is built a few cells beside its place.
If boats find no way to the largest part, the next one is tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from mission_computer.assembly.constraint_model import SolverLimits
from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.largest_part import BuildablePart, largest_part
from mission_computer.assembly.structure import Part, Structure, part_of
from mission_computer.assembly.timed_plan import TimedLimits, plan_timed_paths
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import OFFSETS
from swarm_msgs_py.assembly.plan import AssemblyPlan, Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import NoDispatchError

SOLVER_WORK = 10.0
"""Deterministic solver time for one part."""
PARTS_MAX = 12
"""Parts to which ways are looked for before what stands must do."""
SHIFTS = ((0, 0), *((far * x, far * y) for far in (2, 4) for x, y in OFFSETS))
"""Where else the structure is built, relative to its place, if a dead boat is in the way there; tried in turn."""


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


@dataclass(frozen=True, slots=True)
class Rest:
    """What can still be built, and how.

    Attributes
    ----------
    problem : AssemblyProblem
        The places that are kept as targets, maybe all shifted alike; boats and starts as they are now.
    plan : AssemblyPlan
        With timed paths.
    is_largest : bool
        Whether it is proven that no larger part of the structure can be put together.
    """

    problem: AssemblyProblem
    plan: AssemblyPlan
    is_largest: bool


class NothingToAddError(NoDispatchError):
    """Nothing can be added to what stands.

    Parameters
    ----------
    message : str
    is_proof : bool
        Whether that is proven; else nothing was found.
    """

    def __init__(self, message: str, *, is_proof: bool) -> None:
        super().__init__(message)
        self.is_proof = is_proof


def plan_rest(midway: Midway, seed: int, limits: TimedLimits) -> Rest:
    """Return what can still be built, and the plan of it.

    Raises
    ------
    NothingToAddError
        If nothing can be added to what stands.
    """
    problem = _without_lone_dead(midway)
    stands = max((len(group) for group in midway.groups), default=1)
    tried: list[BuildablePart] = []
    while len(tried) < PARTS_MAX:
        part = largest_part(problem, midway.groups, midway.suspects, tried, SolverLimits(seed, SOLVER_WORK))
        if part is None or len(part.targets) <= stands:
            break
        rest = _moved(problem, part, seed, limits)
        if rest is not None:
            # Later bounds hold for what is left when parts are forbidden, and that nobody found a way is no proof.
            bound = tried[0].bound if tried else part.bound
            return Rest(*rest, is_largest=len(part.targets) == bound)
        tried.append(part)
    raise NothingToAddError(
        f"{problem.name}: nothing can be added to what stands with the boats that are left",
        is_proof=not tried and part is not None and part.bound <= stands,
    )


def _moved(
    problem: AssemblyProblem, part: BuildablePart, seed: int, limits: TimedLimits
) -> tuple[AssemblyProblem, AssemblyPlan] | None:
    """Return the problem with the targets of a part, and a plan of it; None if no way was found to move the boats."""
    places = {boat: place for place, boat in enumerate(part.dispatch.boats)}
    atoms = [part_of(places[boat] for boat in group) for group in part.groups]
    smaller = replace(problem, targets=tuple(problem.targets[target] for target in part.targets))
    for shifted in _beside(smaller):
        plan = _moves(shifted, part.dispatch, atoms, seed, limits)
        if plan is not None:
            return shifted, plan
    return None


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


def _moves(
    problem: AssemblyProblem, dispatch: Dispatch, atoms: Sequence[Part], seed: int, limits: TimedLimits
) -> AssemblyPlan | None:
    structure = Structure(problem.targets, atoms)
    docked = docked_contacts(problem.targets, dispatch.layouts(problem), problem.gender)
    timed = plan_timed_paths(problem, dispatch, CutForest(structure, docked), seed, limits)
    return None if timed is None else AssemblyPlan(dispatch, timed.tree, None, timed.paths, 1)
