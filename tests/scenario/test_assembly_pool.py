"""Boats in a pool build structures by contact, under wind and waves, and go on when something is lost."""

from dataclasses import replace

import pytest

from mission_computer.assembly.foreman import ForemanState
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_guideposts, plan_with_timed_paths
from mission_computer.assembly.tabu_search import TabuLimits
from mission_computer.assembly.timed_plan import TimedLimits
from studies.pool_assembly import Faults, PoolOutcome, assemble_in_pool, is_built, with_random_turns
from swarm_msgs_py.assembly.faces import Face, Gender
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_sim.boats.pool import BodyKind

QUICK = TimedPlannerLimits(dispatches=1, timed=TimedLimits(attempts=2))


def planned(name: str, gender: Gender, seed: int) -> tuple[AssemblyProblem, AssemblyPlan]:
    problem = load_problem(name, gender)
    if name.startswith("boats"):
        problem = with_random_turns(problem, seed)
    return problem, plan_with_timed_paths(problem, seed, QUICK)


def built(name: str, gender: Gender, faults: Faults, kind: BodyKind = BodyKind.PLANAR) -> PoolOutcome:
    return assemble_in_pool(*planned(name, gender, 1), 1, kind, faults)


@pytest.mark.parametrize("kind", list(BodyKind))
def test_four_boats_build_a_square_by_contact(kind: BodyKind) -> None:
    outcome = built("boats_5_square", Gender.OPPOSITE, Faults(), kind)

    assert is_built(outcome), outcome.audit
    assert outcome.audit.docked_contacts == outcome.audit.wanted_contacts


@pytest.mark.parametrize("frame_loss", [0.0, 0.2])
def test_boats_that_find_their_ways_by_themselves_dock_by_contact(frame_loss: float) -> None:
    problem = load_problem("boats_5_square", Gender.OPPOSITE)
    plan = plan_with_guideposts(problem, 1, TabuLimits())

    outcome = assemble_in_pool(problem, plan, 1, BodyKind.PLANAR, Faults(frame_loss=frame_loss))

    assert is_built(outcome), outcome.audit
    assert outcome.report.epoch == 1


def test_when_a_boat_that_finds_its_way_dies_the_rest_is_planned_for_all() -> None:
    problem = load_problem("boats_5_square", Gender.GENDERLESS)
    problem = replace(problem, starts=(*problem.starts, (8, 2)), layouts=(*problem.layouts, (1, 1, 1, 1)))
    plan = plan_with_guideposts(problem, 1, TabuLimits())
    dead = plan.dispatch.boats[0]

    outcome = assemble_in_pool(problem, plan, 1, BodyKind.PLANAR, Faults(deaths={dead: 12.0}))

    assert is_built(outcome), outcome.audit
    assert outcome.report.epoch == 2


def test_lost_frames_cost_time_and_nothing_else() -> None:
    assert is_built(built("map_1", Gender.GENDERLESS, Faults(frame_loss=0.2)))


def test_a_spare_boat_takes_the_place_of_one_that_dies_on_its_way() -> None:
    problem = load_problem("boats_5_square", Gender.GENDERLESS)
    problem = replace(problem, starts=(*problem.starts, (8, 2)), layouts=(*problem.layouts, (1, 1, 1, 1)))
    plan = plan_with_timed_paths(problem, 1, QUICK)
    dead = plan.dispatch.boats[0]

    outcome = assemble_in_pool(problem, plan, 1, BodyKind.PLANAR, Faults(deaths={dead: 3.0}))

    assert is_built(outcome), outcome.audit
    assert outcome.report.epoch == 2
    assert f"boat {dead} fell silent" in outcome.report.note


def test_without_a_spare_the_largest_part_is_built_and_said_so() -> None:
    outcome = built("boats_3_l_shape", Gender.GENDERLESS, Faults(deaths={3: 5.0}))

    assert outcome.report.state is ForemanState.DONE
    assert (outcome.report.built, outcome.report.wanted) == (3, 4)
    assert outcome.report.note == (
        "boat 3 fell silent on its way; 1 of 4 places are given up; "
        "finished the largest connected sub-structure: 3 of 4 (proven: no larger one can be put together)"
    )
    assert outcome.audit.is_complete_and_clean


def test_a_boat_that_dies_docked_is_carried_along() -> None:
    problem, plan = planned("map_1", Gender.GENDERLESS, 1)
    assert plan.paths is not None
    root = plan.tree.nodes[0]
    crew = next(node for node in plan.tree.nodes[1:] if node.parent == 0 and len(node.targets) > 1)
    assert root.axis is not None
    dead = plan.dispatch.boats[crew.targets[0]]

    outcome = assemble_in_pool(problem, plan, 1, BodyKind.PLANAR, Faults(deaths={dead: 27.0}))

    assert outcome.report.state is ForemanState.DONE
    assert outcome.report.built >= problem.target_count - 1
    assert outcome.audit.is_complete_and_clean


def test_a_dock_that_does_not_hold_is_noticed_and_the_rest_is_built() -> None:
    problem, plan = planned("boats_4_line", Gender.GENDERLESS, 1)
    boat = plan.dispatch.boats[0]
    faults = Faults(magnets={(boat, face): 1.0 for face in Face})

    outcome = assemble_in_pool(problem, plan, 1, BodyKind.PLANAR, faults)

    assert outcome.report.state in (ForemanState.DONE, ForemanState.GAVE_UP)
    assert "do not hold" in outcome.report.note
    assert 2 <= outcome.report.built < 4
    assert f"largest connected sub-structure: {outcome.report.built} of 4" in outcome.report.note
    assert not [line for line in outcome.audit.violations if "no such neighbors" in line or "ran into" in line]


def test_a_spare_boat_takes_the_place_of_one_whose_magnets_fail() -> None:
    problem = load_problem("boats_4_line", Gender.GENDERLESS)
    problem = replace(problem, starts=(*problem.starts, (8, 14)), layouts=(*problem.layouts, (1, 1, 1, 1)))
    plan = plan_with_timed_paths(problem, 1, QUICK)
    boat = plan.dispatch.boats[0]

    outcome = assemble_in_pool(problem, plan, 1, BodyKind.BULLET, Faults(magnets={(boat, face): 1.0 for face in Face}))

    assert is_built(outcome), (outcome.report, outcome.audit)


def test_equal_seeds_give_equal_assemblies() -> None:
    first, second = (built("boats_1_s_shape", Gender.GENDERLESS, Faults(frame_loss=0.1)) for _ in range(2))

    assert first.track.tobytes() == second.track.tobytes()
    assert replace(first.report) == second.report
