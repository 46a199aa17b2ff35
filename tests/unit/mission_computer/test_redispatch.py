"""Plans for the rest of an assembly: docked groups stay together, free boats are dispatched anew."""

from dataclasses import replace

import numpy as np
import pytest
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly.redispatch import Midway, Rest, plan_rest
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_msgs_py.assembly.plan import AssemblyPlan, Dispatch
from swarm_msgs_py.assembly.problem import CLEARANCE, AssemblyProblem
from swarm_msgs_py.errors import NoDispatchError
from swarm_sim.metrics.assembly import audit_assembly

LIMITS = TimedLimits(attempts=4)
SQUARE = block(2, 2)  # targets 0 lower left, 1 upper left, 2 lower right, 3 upper right


def midway(starts: list[tuple[int, int]], groups: tuple[tuple[int, ...], ...], dead: frozenset[int]) -> Midway:
    problem = problem_of(SQUARE, [ALL_SIDES] * len(starts))
    stopped = replace(problem, starts=tuple(starts), is_midway=True)
    return Midway(stopped, Dispatch((0, 1, 2, 3), (0,) * 4), groups, dead)


def checked(rest: Rest) -> tuple[AssemblyProblem, AssemblyPlan]:
    problem, plan = rest.problem, rest.plan
    assert plan.paths is not None
    audit = audit_assembly(problem, plan.dispatch, plan.paths.cells)
    assert not [line for line in audit.violations if not line.startswith("step 0")]
    assert audit.components == 1
    return problem, plan


def test_a_docked_pair_moves_on_as_one_and_keeps_its_places() -> None:
    problem, plan = checked(plan_rest(midway([(5, 5), (5, 6), (20, 5), (20, 12)], ((0, 1),), frozenset()), 1, LIMITS))

    assert plan.paths is not None
    assert plan.dispatch.boats[:2] == (0, 1)
    assert plan.dispatch.turns[:2] == (0, 0)
    cells = plan.paths.cells
    assert ((cells[:, 1] - cells[:, 0]) == (0, 1)).all()
    assert problem.target_count == 4
    assert (0, 1) in [tuple(sorted(node.targets)) for node in plan.tree.nodes if not node.children]


def test_a_spare_boat_replaces_a_dead_one() -> None:
    starts = [(5, 5), (5, 10), (20, 5), (20, 12), (25, 25)]
    problem, plan = checked(plan_rest(midway(starts, (), frozenset({2})), 1, LIMITS))

    assert problem.target_count == 4
    assert sorted(plan.dispatch.boats) == [0, 1, 3, 4]


def test_a_boat_whose_docks_did_not_hold_is_left_out_only_while_there_is_another() -> None:
    starts = [(5, 5), (5, 10), (20, 5), (20, 12), (25, 25)]
    suspicious = replace(midway(starts, (), frozenset()), suspects=frozenset({2}))
    alone = replace(midway(starts[:4], (), frozenset()), suspects=frozenset({2}))

    _, with_spare = checked(plan_rest(suspicious, 1, LIMITS))
    _, without = checked(plan_rest(alone, 1, LIMITS))

    assert sorted(with_spare.dispatch.boats) == [0, 1, 3, 4]
    assert sorted(without.dispatch.boats) == [0, 1, 2, 3]


def test_nothing_is_built_beside_a_boat_that_stays_behind() -> None:
    starts = [(5, 5), (5, 6), (20, 12), (12, 20), (5, 7)]
    stopped = replace(midway(starts, ((0, 1),), frozenset()), suspects=frozenset({4}))
    layouts = (*stopped.problem.layouts[:4], (1, 0, 1, 1))  # its lower side met boat 1, and did not hold
    stopped = replace(stopped, problem=replace(stopped.problem, layouts=layouts))

    problem, plan = checked(plan_rest(stopped, 1, LIMITS))

    assert problem.target_count == 4
    assert sorted(plan.dispatch.boats) == [0, 1, 2, 3]
    assert plan.paths is not None
    gaps = np.abs(plan.paths.cells[1:, :4] - np.array(starts[4])).max(axis=2)
    assert gaps.min() >= CLEARANCE


def test_without_a_spare_as_many_places_as_possible_are_kept() -> None:
    starts = [(5, 5), (5, 10), (20, 5), (20, 12)]
    problem, plan = checked(plan_rest(midway(starts, (), frozenset({2})), 1, LIMITS))

    assert problem.target_count == 3
    assert sorted(plan.dispatch.boats) == [0, 1, 3]


def test_a_smaller_part_is_no_proof_where_only_the_way_to_a_larger_one_was_not_found() -> None:
    walled_in = (25, 25)
    stopped = midway([(5, 5), (5, 10), (20, 5), walled_in], (), frozenset())
    reach = range(-3, 4)
    wall = tuple((25 + x, 25 + y) for x in reach for y in reach if max(abs(x), abs(y)) == max(reach))
    enclosed = replace(stopped, problem=replace(stopped.problem, obstacles=wall))

    rest = plan_rest(enclosed, 1, LIMITS)

    assert sorted(rest.plan.dispatch.boats) == [0, 1, 2]
    assert not rest.is_largest
    assert plan_rest(stopped, 1, LIMITS).is_largest


def test_nothing_is_planned_where_no_boat_can_dock() -> None:
    lost = midway([(5, 5), (5, 10), (20, 5), (20, 12)], (), frozenset({0, 1, 2, 3}))

    with pytest.raises(NoDispatchError, match="nothing can be added"):
        plan_rest(lost, 1, LIMITS)


def test_the_structure_is_built_beside_a_dead_boat_that_lies_in_its_place() -> None:
    starts = [(5, 5), (5, 6), (12, 12), (20, 5), (20, 12)]
    problem, plan = checked(plan_rest(midway(starts, ((0, 1),), frozenset({2})), 1, LIMITS))

    assert problem.target_count == 4
    assert set(problem.targets) == {(x, y + 2) for x, y in SQUARE}
    assert sorted(plan.dispatch.boats) == [0, 1, 3, 4]
