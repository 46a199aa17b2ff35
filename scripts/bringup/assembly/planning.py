"""The plan of a scenario: made once per process, because whether there is one is part of the checks."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache

from bringup.assembly.scenario import AssemblyScenario, MapSpec, Navigation
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_guideposts, plan_with_timed_paths
from mission_computer.assembly.tabu_search import TabuLimits
from swarm_msgs_py.assembly.faces import QUARTER_TURNS, turned
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.randomness import rng_for


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMission:
    """What is to be built, and how.

    Attributes
    ----------
    problem : AssemblyProblem
    plan : AssemblyPlan
    wall_s : float
        That planning took [s].
    """

    problem: AssemblyProblem
    plan: AssemblyPlan
    wall_s: float


def planned(scenario: AssemblyScenario) -> PlannedMission:
    """Return the mission of a scenario.

    Raises
    ------
    AssemblyError
        If the map is none, or nothing can be built from it.
    """
    return _planned(scenario.map, scenario.navigation, scenario.seed)


@lru_cache(maxsize=4)
def _planned(spec: MapSpec, navigation: Navigation, seed: int) -> PlannedMission:
    problem = load_problem(spec.name or spec.file or "", spec.docks)
    if spec.random_turns:
        turns = rng_for(seed, "initial orientation").integers(QUARTER_TURNS, size=problem.boat_count).tolist()
        layouts = tuple(turned(layout, turn) for layout, turn in zip(problem.layouts, turns, strict=True))
        problem = replace(problem, layouts=layouts)
    began = time.perf_counter()
    if navigation is Navigation.TIMED:
        plan = plan_with_timed_paths(problem, seed, TimedPlannerLimits())
    else:
        plan = plan_with_guideposts(problem, seed, TabuLimits())
    return PlannedMission(problem, plan, time.perf_counter() - began)
