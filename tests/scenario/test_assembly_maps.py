"""Assemblies on maps of the paper, judged by the audit."""

import pytest

from mission_computer.assembly.generated import Outline, generate_problem
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_guideposts, plan_with_timed_paths
from mission_computer.assembly.tabu_search import TabuLimits
from mission_computer.assembly.timed_plan import TimedLimits
from studies.assembly_runs import assemble_decentralized, assemble_timed
from swarm_msgs_py.assembly.faces import Gender

BRIEF = TimedPlannerLimits(dispatches=1, timed=TimedLimits(attempts=2))


@pytest.mark.parametrize("gender", Gender)
@pytest.mark.parametrize(("name", "steps_max"), [("map_1", 18), ("map_2", 20)])
def test_timed_guideposts_build_a_map_in_few_steps(name: str, steps_max: int, gender: Gender) -> None:
    outcome = assemble_timed(load_problem(name, gender), 1, TimedPlannerLimits())

    assert outcome.audit.violations == ()
    assert outcome.audit.steps <= steps_max


@pytest.mark.parametrize("gender", Gender)
def test_boats_find_their_ways_on_map_1_by_themselves(gender: Gender) -> None:
    problem = load_problem("map_1", gender)

    outcome = assemble_decentralized(problem, plan_with_guideposts(problem, 1, TabuLimits()), 1)

    assert outcome.audit.violations == ()


def test_boats_break_no_rule_when_frames_are_lost() -> None:
    problem = load_problem("map_1", Gender.GENDERLESS)
    plan = plan_with_guideposts(problem, 1, TabuLimits())

    outcome = assemble_decentralized(problem, plan, 1, frame_loss=0.2, steps_max=300)

    assert outcome.audit.violations == ()
    assert outcome.audit.steps >= plan.dispatch.longest_travel(problem)


@pytest.mark.parametrize("outline", Outline)
def test_a_generated_structure_is_built(outline: Outline) -> None:
    outcome = assemble_timed(generate_problem(outline, 45, Gender.OPPOSITE, 2), 2, BRIEF)

    assert outcome.audit.violations == ()


def test_equal_seeds_give_equal_plans() -> None:
    problem = load_problem("map_2", Gender.GENDERLESS)

    one, other = (plan_with_timed_paths(problem, 7, BRIEF) for _ in range(2))

    assert one.paths is not None
    assert other.paths is not None
    assert one.paths.cells.tobytes() == other.paths.cells.tobytes()
    assert (one.dispatch, one.tree) == (other.dispatch, other.tree)
