"""The whole planning of an assembly on the mission computer: stages I to III, or timed paths for all boats."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice

from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.dispatching import EXACT_TARGETS_MAX, DispatchLimits, dispatches
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.tabu_search import TabuLimits, tabu_dispatch
from mission_computer.assembly.timed_plan import TimedLimits, plan_timed_paths
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.plan import AssemblyPlan, Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import NoDispatchError
from swarm_msgs_py.randomness import rng_for


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedPlannerLimits:
    """Bounds of planning with timed paths.

    Attributes
    ----------
    dispatches : int
        Dispatches that are worked out to paths; one, where the structure is too large for the constraint program.
    slack : int
        Steps beyond the longest travel of its dispatch with which a plan is good enough to stop.
    dispatch : DispatchLimits
    timed : TimedLimits
    """

    dispatches: int = 3
    slack: int = 1
    dispatch: DispatchLimits = field(default_factory=DispatchLimits)
    timed: TimedLimits = field(default_factory=TimedLimits)


def plan_with_timed_paths(problem: AssemblyProblem, seed: int, limits: TimedPlannerLimits) -> AssemblyPlan:
    """Return the plan of fewest steps among several dispatches: the default mode.

    Raises
    ------
    NoDispatchError
        If there is no dispatch that can be put together, or no way to move the boats was found.
    """
    structure = Structure(problem.targets)
    best: AssemblyPlan | None = None
    count = 0
    tried = limits.dispatches if problem.target_count <= EXACT_TARGETS_MAX else 1
    for dispatch in islice(dispatches(problem, structure, seed, limits.dispatch), tried):
        count += 1
        timed = plan_timed_paths(problem, dispatch, forest_of(problem, structure, dispatch), seed + count, limits.timed)
        if timed is None:
            continue
        if best is None or best.paths is None or timed.paths.steps < best.paths.steps:
            best = AssemblyPlan(dispatch, timed.tree, None, timed.paths, count)
        if timed.paths.steps <= dispatch.longest_travel(problem) + limits.slack:
            break
    if best is None:
        raise NoDispatchError(
            f"{problem.name}: found no way to move the boats; give the structure more room in the grid"
        )
    return best


def plan_with_guideposts(problem: AssemblyProblem, seed: int, limits: TabuLimits) -> AssemblyPlan:
    """Return the plan of the published method, stages I to III: boats find their ways by themselves.

    Raises
    ------
    NoDispatchError
        If the search finds no dispatch that can be put together.
    AssemblyError
        If the extension does not fit the grid.
    """
    found = tabu_dispatch(problem, Structure(problem.targets), rng_for(seed, "tabu"), limits)
    return AssemblyPlan(found.best.dispatch, found.best.tree, found.best.guideposts, None, found.feasible)


def forest_of(problem: AssemblyProblem, structure: Structure, dispatch: Dispatch) -> CutForest:
    """Return the trees of a dispatched structure."""
    return CutForest(structure, docked_contacts(problem.targets, dispatch.layouts(problem), problem.gender))
