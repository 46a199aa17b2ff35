"""The order in timed paths: who leaves before whom, and rings that nobody could leave."""

from dataclasses import replace

import numpy as np
from assembly_problems import ALL_SIDES, problem_of

from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, TimedPaths, TreeNode
from swarm_msgs_py.assembly.precedence import crews_of, needed_steps, turning_step, waits_in_ring

LINE = problem_of([(10, 10), (11, 10)], [ALL_SIDES] * 2, starts=[(6, 10), (13, 10)])
PAIR = AssemblyTree((TreeNode((0, 1), -1, (1, 2), Axis.X, 10), TreeNode((0,), 0), TreeNode((1,), 0)))
STRAIGHT = Dispatch((0, 1), (0, 0))


def paths(*rows: list[tuple[int, int]]) -> TimedPaths:
    return TimedPaths(np.array(rows))


MEETING = paths(
    [(6, 10), (13, 10)], [(7, 10), (13, 10)], [(8, 10), (13, 10)], [(9, 10), (12, 10)], [(10, 10), (11, 10)]
)


def test_boats_are_one_crew_from_the_step_in_which_they_dock() -> None:
    crews = crews_of(LINE, STRAIGHT, PAIR, MEETING, 0)

    assert crews == [(0,), (0,), (0,), (0,), (0, 1)]


def test_partners_make_the_last_step_together() -> None:
    crews = crews_of(LINE, STRAIGHT, PAIR, MEETING, 0)
    boats = np.array([0, 1])

    assert needed_steps(crews, MEETING.cells, boats, 0, 3) == {1: 3}
    assert needed_steps(crews, MEETING.cells, boats, 0, 0) == {}


def test_boats_turn_where_they_start_unless_somebody_is_beside_them() -> None:
    crews = crews_of(LINE, STRAIGHT, PAIR, MEETING, 0)
    beside = paths([(8, 10), (9, 10)], [(8, 10), (10, 10)], [(7, 10), (10, 10)], [(10, 10), (11, 10)])

    assert turning_step(LINE, crews, MEETING.cells, 0) == 0
    assert turning_step(LINE, crews_of(LINE, STRAIGHT, PAIR, beside, 0), beside.cells, 0) == 1


def test_boats_that_were_stopped_side_by_side_do_not_wait_for_each_other() -> None:
    stopped = replace(LINE, is_midway=True)
    beside = paths(
        [(8, 10), (9, 10)], [(8, 10), (9, 10)], [(7, 10), (9, 10)], [(8, 10), (10, 10)], [(10, 10), (11, 10)]
    )

    for boat in (0, 1):
        crews = crews_of(stopped, STRAIGHT, PAIR, beside, boat)
        assert needed_steps(crews, beside.cells, np.array([0, 1]), boat, 0) == {}
    assert not waits_in_ring(stopped, STRAIGHT, PAIR, beside)


def test_boats_that_were_stopped_and_change_places_wait_in_a_ring() -> None:
    stopped = replace(LINE, is_midway=True)
    swapping = paths([(8, 10), (9, 10)], [(9, 10), (8, 10)], [(10, 10), (8, 10)], [(10, 10), (11, 10)])

    assert waits_in_ring(stopped, STRAIGHT, PAIR, swapping)


def test_paths_that_only_follow_or_meet_have_no_ring() -> None:
    assert not waits_in_ring(LINE, STRAIGHT, PAIR, MEETING)


def test_boats_that_chase_each_other_around_wait_in_a_ring() -> None:
    ring = [(10, 10), (12, 10), (12, 12), (10, 12)]
    onward = [(11, 10), (12, 11), (11, 12), (10, 11)]
    problem = problem_of([(20, 20), (21, 20), (22, 20), (23, 20)], [ALL_SIDES] * 4, starts=ring)
    tree = AssemblyTree(
        (
            TreeNode((0, 1, 2, 3), -1, (1, 2), Axis.X, 21),
            TreeNode((0, 1), 0, (3, 4), Axis.X, 20),
            TreeNode((2, 3), 0, (5, 6), Axis.X, 22),
            *(TreeNode((target,), parent) for target, parent in ((0, 1), (1, 1), (2, 2), (3, 2))),
        )
    )

    assert waits_in_ring(problem, Dispatch((0, 1, 2, 3), (0,) * 4), tree, paths(ring, onward))
