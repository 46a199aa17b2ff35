"""Collision avoidance: never an overlap, never a deadlock."""

from __future__ import annotations

import numpy as np
import pytest
from crowd import PERIOD, SPEED, move_crowd
from numpy.testing import assert_allclose, assert_array_equal

from swarm_agent.control.avoidance import Avoidance
from swarm_agent.control.config import AvoidanceConfig, YieldingConfig
from swarm_agent.control.yielding import make_way

RADIUS = 0.3
REST = np.zeros(2)
AHEAD = np.array([SPEED, 0.0])


def make_avoidance() -> Avoidance:
    return Avoidance(AvoidanceConfig(), RADIUS, PERIOD)


def test_with_nothing_near_a_robot_does_what_it_wants() -> None:
    assert_array_equal(make_avoidance().step(AHEAD, REST, np.empty((0, 2)), 10.0), AHEAD)


def test_what_lies_beyond_the_destination_does_not_matter() -> None:
    wall_behind_goal = np.array([[1.6, 0.0]])

    assert_array_equal(make_avoidance().step(AHEAD, REST, wall_behind_goal, 0.3), AHEAD)


def test_two_robots_use_up_at_most_the_gap_between_them_in_one_tick() -> None:
    gap = 0.2
    contact = np.array([[RADIUS + gap, 0.0]])

    velocity = make_avoidance().step(AHEAD, REST, contact, 10.0)

    assert velocity[0] * PERIOD <= gap / 2


def test_coasting_on_the_old_setpoint_is_counted() -> None:
    contact = np.array([[RADIUS + 0.4, 0.0]])
    config = AvoidanceConfig()

    velocity = make_avoidance().step(AHEAD, AHEAD, contact, 10.0)

    assert velocity[0] * PERIOD + SPEED * config.servo_delay_s <= 0.2 - config.margin_m + 1e-12


def test_a_resting_robot_backs_out_of_a_margin() -> None:
    contact = np.array([[RADIUS + 0.01, 0.0]])

    velocity = make_avoidance().step(REST, REST, contact, 0.0)

    assert velocity[0] < 0.0
    assert velocity[1] == 0.0


def test_passes_an_obstacle_ahead_on_the_right() -> None:
    velocity = make_avoidance().step(AHEAD, REST, np.array([[1.0, 0.0]]), 10.0)

    assert velocity[1] < 0.0 < velocity[0]


def test_follows_a_robot_that_drives_ahead_at_the_same_speed() -> None:
    avoidance = make_avoidance()
    contact = np.array([[RADIUS + 0.9, 0.0]])
    velocity = AHEAD
    for _ in range(4):
        velocity = avoidance.step(AHEAD, AHEAD, contact, 20.0)

    assert_allclose(velocity, AHEAD)


def test_who_wants_nothing_is_not_blocked() -> None:
    avoidance = make_avoidance()
    angles = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    cage = (RADIUS + 0.08) * np.column_stack([np.cos(angles), np.sin(angles)])
    for _ in range(20):
        avoidance.step(AHEAD, REST, cage, 10.0)
    assert avoidance.is_blocked

    avoidance.step(REST, REST, cage, 0.0)

    assert not avoidance.is_blocked


@pytest.mark.parametrize("insist_s", [0.0, 1.5])
def test_a_blocked_robot_asks_for_way_until_it_has_got_on_for_long_enough(insist_s: float) -> None:
    """Those that make way would come back at its first step otherwise."""
    avoidance = Avoidance(AvoidanceConfig(insist_s=insist_s), RADIUS, PERIOD)
    gate = np.array([[0.05, RADIUS + 0.02], [0.05, -RADIUS - 0.02]])  # not to be squeezed through
    for _ in range(20):
        avoidance.step(AHEAD, REST, gate, 10.0)
    assert avoidance.is_blocked

    def asks_while(contacts: np.ndarray, ticks: int) -> list[bool]:
        asked = []
        for _ in range(ticks):
            avoidance.step(AHEAD, AHEAD, contacts, 10.0)
            asked.append(avoidance.is_blocked)
        return asked

    wider, insisting = 5.0 * gate, round(insist_s / PERIOD)
    assert asks_while(wider, 2) == [insisting > 1, insisting > 2]
    asks_while(gate, 20)  # it closes again
    assert asks_while(wider, insisting + 2) == [True] * max(insisting - 1, 0) + [False] * (2 + min(insisting, 1))


def antipodal(n: int) -> tuple[np.ndarray, np.ndarray]:
    angles = np.arange(n) * 2 * np.pi / n
    circle = max(4.0, 0.6 * n) * np.column_stack([np.cos(angles), np.sin(angles)])
    return circle, -circle


@pytest.mark.parametrize("n", [2, 3, 8, 14, 24])
def test_robots_that_swap_across_a_circle_all_arrive_without_touching(n: int) -> None:
    starts, goals = antipodal(n)

    result = move_crowd(starts, goals, np.resize([0.15, 0.3, 0.5], n))

    assert result.arrived_after is not None
    assert result.min_gap > 0.0
    assert result.detour < 1.25


@pytest.mark.parametrize("seed", [16, 17, 23, 29])  # shut in by parked robots, unless those make way
def test_a_robot_that_is_shut_in_by_parked_robots_gets_through(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = np.array([[i, j] for i in range(4) for j in range(3)]) * 1.5

    result = move_crowd(places, places[rng.permutation(12)], np.resize([0.15, 0.3, 0.5], 12), seed=seed)

    assert result.arrived_after is not None
    assert result.min_gap > 0.0


def test_nobody_makes_way_for_a_robot_far_off() -> None:
    far = np.array([[3.0, 0.0]])

    assert make_way(REST, REST, far, YieldingConfig()) is None


def test_making_way_ends_at_the_farthest_step() -> None:
    config = YieldingConfig()
    stepped = np.array([config.displacement_max_m + 0.1, 0.0])

    velocity = make_way(stepped, REST, np.array([stepped - [1.0, 0.0]]), config)

    assert velocity is not None
    assert_array_equal(velocity, REST)


def test_a_robot_on_its_way_to_a_far_goal_does_not_stop_for_a_blocked_one() -> None:
    config = YieldingConfig()

    assert make_way(np.array([2.0 * config.displacement_max_m, 0.0]), REST, np.array([[3.0, 0.0]]), config) is None


def test_making_way_leads_away_from_the_blocked_robot() -> None:
    velocity = make_way(REST, REST, np.array([[-1.0, 0.0]]), YieldingConfig())

    assert velocity is not None
    assert velocity[0] > 0.0
