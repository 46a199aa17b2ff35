"""From a path to a preferred velocity."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from swarm_agent.control.config import ControlConfig
from swarm_agent.control.path_follower import PathFollower
from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.types import FloatArray

PERIOD = 0.5
RADIUS = 0.3
CONFIG = ControlConfig()
OPEN = planner_for((), RADIUS, PlanningConfig())
WALL = np.array([[4.0, -3.0], [5.0, -3.0], [5.0, 3.0], [4.0, 3.0]])
WALLED = planner_for((WALL,), RADIUS, PlanningConfig())
GOAL = np.array([9.0, 0.0])


def make_follower() -> PathFollower:
    return PathFollower(CONFIG, PERIOD, RADIUS)


def drive(follower: PathFollower, planner: object, position: FloatArray, ticks: int) -> list[FloatArray]:
    track = [position]
    for _ in range(ticks):
        position = position + follower.step(planner, position, GOAL) * PERIOD  # type: ignore[arg-type]
        track.append(position)
    return track


def test_far_from_the_goal_it_drives_at_full_speed_straight_there() -> None:
    velocity = make_follower().step(OPEN, np.zeros(2), GOAL)

    assert_allclose(velocity, [CONFIG.speed_max_m_s, 0.0])


def test_close_to_the_goal_speed_is_proportional_to_distance() -> None:
    velocity = make_follower().step(OPEN, GOAL - [0.2, 0.0], GOAL)

    assert_allclose(velocity, [0.2 * CONFIG.gain_1_s, 0.0])


def test_parks_with_hysteresis() -> None:
    follower = make_follower()
    between = (CONFIG.park_m + CONFIG.unpark_m) / 2

    follower.step(OPEN, np.array([9.0, between]), GOAL)
    assert not follower.is_parked
    assert_array_equal(follower.step(OPEN, GOAL, GOAL), [0.0, 0.0])
    assert follower.is_parked
    follower.step(OPEN, np.array([9.0, between]), GOAL)
    assert follower.is_parked
    follower.step(OPEN, np.array([9.0, CONFIG.unpark_m + 0.01]), GOAL)
    assert not follower.is_parked


def test_goes_around_a_wall_without_entering_its_margin() -> None:
    track = drive(make_follower(), WALLED, np.zeros(2), 80)

    assert_allclose(track[-1], GOAL, atol=CONFIG.park_m)
    for position in track:
        assert WALLED.space.is_free(position) or np.hypot(*(WALLED.space.project(position) - position)) < 1e-6


def test_the_way_driven_is_as_long_as_the_path() -> None:
    track = np.array(drive(make_follower(), WALLED, np.zeros(2), 80))
    (length,) = WALLED.costs(np.zeros(2), GOAL[None])

    assert np.hypot(*np.diff(track, axis=0).T).sum() < length + 0.02


def test_pushed_behind_a_corner_it_plans_anew() -> None:
    follower = make_follower()
    drive(follower, WALLED, np.array([4.5, 4.0]), 2)
    assert len(follower.path) == 1

    follower.step(WALLED, np.array([3.0, 0.0]), GOAL)

    assert len(follower.path) > 1


def test_without_a_destination_it_stands() -> None:
    follower = make_follower()
    follower.step(OPEN, np.zeros(2), GOAL)

    assert_array_equal(follower.step(OPEN, np.zeros(2), None), [0.0, 0.0])
    assert len(follower.path) == 0


def test_without_a_way_it_stands() -> None:
    inside_wall = WALL.mean(axis=0)

    assert_array_equal(make_follower().step(WALLED, np.zeros(2), inside_wall), [0.0, 0.0])


def test_an_uncertain_robot_does_not_follow_the_noise_of_its_estimate() -> None:
    follower = make_follower()
    sigma = 0.3

    follower.step(OPEN, GOAL + 0.1, GOAL, sigma)
    assert follower.is_parked
    follower.step(OPEN, GOAL + 2 * sigma, GOAL, sigma)
    assert follower.is_parked
    follower.step(OPEN, GOAL + 4 * sigma, GOAL, sigma)
    assert not follower.is_parked


def test_a_corner_stays_ahead_while_something_is_sensed_on_the_leg_after_it() -> None:
    """The robot believes to be past the wall's end; what it senses tells that it is not."""
    follower = make_follower()
    follower.step(WALLED, np.array([3.0, 3.6]), GOAL)
    corner = follower.path[0].copy()
    past = corner + np.array([0.7, 0.3])  # from here the goal is in sight, on the map
    leg = GOAL - past
    wall = 0.25 * leg[None] / np.hypot(*leg)

    blocked = follower.step(WALLED, past, GOAL, contacts=wall)
    ways = len(follower.path)
    free = follower.step(WALLED, past, GOAL, contacts=-wall)

    assert ways > 1
    assert blocked @ (corner - past) > 0.0
    assert_array_equal(follower.path, [GOAL])
    assert free @ leg > 0.99 * np.hypot(*free) * np.hypot(*leg)


def test_a_corner_that_is_reached_is_behind_whatever_is_sensed() -> None:
    follower = make_follower()
    follower.step(WALLED, np.array([3.0, 3.6]), GOAL)
    corner = follower.path[0].copy()

    follower.step(WALLED, corner + np.array([0.0, 0.01]), GOAL, contacts=np.array([[0.25, -0.1]]))

    assert not np.array_equal(follower.path[0], corner)
