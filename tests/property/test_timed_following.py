"""Boats that follow timed guideposts may be late by any time, and still break no rule."""

import numpy as np
import pytest

from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_timed_paths
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_agent.assembly.timed_following import TimedFollower
from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.assembly import audit_assembly


def planned(gender: Gender) -> tuple[AssemblyProblem, AssemblyPlan]:
    problem = load_problem("map_1", gender)
    limits = TimedPlannerLimits(dispatches=1, timed=TimedLimits(attempts=4))
    return problem, plan_with_timed_paths(problem, 1, limits)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("gender", "readiness"), [(Gender.GENDERLESS, 0.3), (Gender.OPPOSITE, 0.8)])
def test_boats_that_are_late_by_chance_break_no_rule(gender: Gender, readiness: float, seed: int) -> None:
    problem, plan = planned(gender)
    assert plan.paths is not None
    boats = {b: TimedFollower(problem, plan.dispatch, plan.tree, plan.paths, b) for b in sorted(plan.dispatch.boats)}
    rng = rng_for(seed, "late")
    cells = [list(problem.starts)]

    for _ in range(600):
        reached = {boat: follower.steps_done for boat, follower in boats.items()}
        crews = {follower.crew for follower in boats.values()}
        now = list(cells[-1])
        for crew in sorted(crews):
            may_go = all(boats[boat].may_go(reached) for boat in crew)
            if may_go and rng.random() < readiness:
                for boat in crew:
                    x, y = now[boat]
                    dx, dy = boats[boat].go().offset
                    now[boat] = (x + dx, y + dy)
        cells.append(now)
        if all(follower.is_done for follower in boats.values()):
            break

    assert audit_assembly(problem, plan.dispatch, np.array(cells)).violations == ()


def test_boats_that_are_never_late_lose_little_by_waiting_until_places_are_left() -> None:
    problem = load_problem("map_2", Gender.GENDERLESS)
    plan = plan_with_timed_paths(problem, 1, TimedPlannerLimits(dispatches=1))
    assert plan.paths is not None
    boats = {b: TimedFollower(problem, plan.dispatch, plan.tree, plan.paths, b) for b in sorted(plan.dispatch.boats)}

    rounds = 0
    while rounds < 2 * plan.paths.steps and not all(follower.is_done for follower in boats.values()):
        reached = {boat: follower.steps_done for boat, follower in boats.items()}
        for follower in [one for one in boats.values() if one.may_go(reached)]:
            follower.go()
        rounds += 1

    assert all(follower.is_done for follower in boats.values())
