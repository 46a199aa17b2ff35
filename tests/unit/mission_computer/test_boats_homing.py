from dataclasses import replace

import numpy as np
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly.homing import HomingLimits, SpaceTime, plan_homing
from swarm_msgs_py.assembly.problem import CLEARANCE

PROBLEM = problem_of(block(2, 2, (4, 4)), [ALL_SIDES] * 4, size=(12, 12), starts=[(1, 1), (1, 4), (1, 7), (1, 10)])


def test_a_free_boat_takes_the_straight_way() -> None:
    path = SpaceTime(PROBLEM, [], 30).earliest((1, 1), (8, 5))

    assert path is not None
    assert len(path) - 1 == 11
    assert path[0].tolist() == [1, 1]
    assert path[-1].tolist() == [8, 5]
    assert (np.abs(np.diff(path, axis=0)).sum(axis=1) <= 1).all()


def test_a_boat_waits_for_one_that_passes() -> None:
    space = SpaceTime(PROBLEM, [], 30)
    space.reserve(np.array([(5, y) for y in range(1, 13)]))

    path = space.earliest((3, 6), (9, 6))

    assert path is not None
    others = np.array([(5, min(1 + step, 12)) for step in range(len(path))])
    assert np.abs(path - others).max(axis=1).min() >= CLEARANCE


def test_a_goal_too_near_to_a_boat_that_stays_is_out_of_reach() -> None:
    assert SpaceTime(PROBLEM, [(8, 8)], 30).earliest((1, 1), (7, 7)) is None


def test_a_boat_that_was_stopped_beside_another_leaves_from_there_but_passes_no_other_such_place() -> None:
    midway = replace(PROBLEM, is_midway=True)
    space = SpaceTime(midway, [(8, 8)], 30)

    back = space.earliest((1, 7), (7, 7))
    past = space.earliest((6, 6), (8, 5))

    assert back is not None
    assert np.abs(back[:-1] - (8, 8)).max(axis=1).min() >= CLEARANCE
    assert past is not None
    assert np.abs(past - (8, 8)).max(axis=1).min() >= CLEARANCE


def test_boats_that_were_stopped_side_by_side_part() -> None:
    midway = replace(PROBLEM, is_midway=True)
    stopped = [(6, 6), (7, 6)]

    paths = plan_homing(midway, [], [(3, 6), (10, 6)], stopped, HomingLimits())

    assert paths is not None
    assert paths[-1].tolist() == [list(cell) for cell in stopped]
    near = np.abs(paths[:, 0] - paths[:, 1]).max(axis=1) < CLEARANCE
    assert (paths[near] == np.array(stopped)).all()
    assert plan_homing(PROBLEM, [], [(3, 6), (10, 6)], stopped, HomingLimits(attempts=4)) is None


def test_two_boats_that_exchange_places_keep_clear() -> None:
    paths = plan_homing(PROBLEM, [], [(2, 6), (10, 6)], [(10, 6), (2, 6)], HomingLimits())

    assert paths is not None
    assert np.abs(paths[:, 0] - paths[:, 1]).max(axis=1).min() >= CLEARANCE
    assert paths[-1].tolist() == [[10, 6], [2, 6]]


def test_boats_that_are_home_need_no_steps() -> None:
    paths = plan_homing(PROBLEM, [], [(2, 6)], [(2, 6)], HomingLimits())

    assert paths is not None
    assert paths.tolist() == [[[2, 6]]]
