"""Stage I, the default: dispatches that first make the longest travel short, because time is what counts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from mission_computer.assembly.constraint_model import DispatchModel, SolverLimits
from mission_computer.assembly.local_search import LocalSearch, LocalSearchLimits, even_tree, shorten_within_classes
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.travel import least_longest_travel, travel_matrix
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import NoDispatchError
from swarm_msgs_py.randomness import rng_for

EXACT_TARGETS_MAX = 40
"""Largest structure for the constraint program; a whole tree of all cuts is in its model."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DispatchLimits:
    """Bounds of the search.

    Attributes
    ----------
    feasible_work : float
        Deterministic solver time for one travel bound.
    proof_work : float
        Deterministic solver time for the question whether there is any dispatch at all.
    travel_work : float
        Deterministic solver time to shorten the total travel.
    local : LocalSearchLimits
    """

    feasible_work: float = 1.0
    proof_work: float = 30.0
    travel_work: float = 0.25
    local: LocalSearchLimits = field(default_factory=LocalSearchLimits)


def dispatches(problem: AssemblyProblem, structure: Structure, seed: int, limits: DispatchLimits) -> Iterator[Dispatch]:
    """Yield dispatches that can be put together, short travels first, without end.

    Raises
    ------
    NoDispatchError
        If there is none, with a proof if the solver has one, or none was found.
    """
    if problem.target_count <= EXACT_TARGETS_MAX:
        yield from _exact(problem, structure, seed, limits)
    else:
        yield from _local(problem, structure, seed, limits)


def _exact(problem: AssemblyProblem, structure: Structure, seed: int, limits: DispatchLimits) -> Iterator[Dispatch]:
    farthest = int(travel_matrix(problem).max())
    bound, stride = least_longest_travel(problem), 1
    round_number = 0
    while True:
        model = DispatchModel(problem, structure, bound)
        is_last = bound >= farthest
        work = limits.proof_work if is_last else limits.feasible_work
        found = model.solve(SolverLimits(seed + round_number, work))
        if found.dispatch is None:
            if is_last:
                raise NoDispatchError(_no_dispatch(problem, found.is_proof))
            bound = min(bound + stride, farthest)
            stride += not found.is_proof  # a bound that is only not answered is left behind faster
            continue
        model.minimize_travel()
        model.hint(found.dispatch)
        shorter = model.solve(SolverLimits(seed + round_number, limits.travel_work)).dispatch or found.dispatch
        yield shorten_within_classes(problem, list(shorter.layouts(problem)), list(shorter.boats))
        round_number += 1
        bound = min(bound + round_number // 2, farthest)  # every second dispatch may travel a little farther


def _local(problem: AssemblyProblem, structure: Structure, seed: int, limits: DispatchLimits) -> Iterator[Dispatch]:
    tree = even_tree(structure)
    if tree is None:
        raise NoDispatchError(_no_dispatch(problem, is_proof=True))
    farthest = int(travel_matrix(problem).max())
    bound = least_longest_travel(problem)
    attempt = 0
    while True:
        search = LocalSearch(problem, structure, tree, bound, rng_for(seed, "local search", attempt))
        attempt += 1
        found = search.run(limits.local)
        if found is not None:
            yield found
        elif bound >= farthest:
            raise NoDispatchError(
                f"{_no_dispatch(problem, is_proof=False)}; the best found leaves {len(search.open_cuts)} lines undocked"
            )
        else:
            bound = min(farthest, bound + max(1, bound // 10))


def _no_dispatch(problem: AssemblyProblem, is_proof: bool) -> str:
    sides = sum(side > 0 for layout in problem.layouts for side in layout)
    what = "no dispatch lets" if is_proof else "found no dispatch that lets"
    return (
        f"{problem.name}: {what} these {problem.gender.value} layouts ({sides} equipped sides) join the"
        f" {problem.target_count} targets pairwise along straight lines{' (proven)' if is_proof else ''}"
    )
