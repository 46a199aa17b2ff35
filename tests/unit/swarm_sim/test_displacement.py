from __future__ import annotations

import itertools

import numpy as np
import pytest

from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.displacement import displacement_bound, path_lengths

RATE = 20.0


def test_a_straight_drive_is_as_long_as_it_is() -> None:
    time = np.arange(0.0, 60.0, 1.0 / RATE)
    positions = np.stack(
        [np.column_stack([0.5 * time, 0.0 * time]), np.column_stack([3.0 + 0 * time, 0 * time])], axis=1
    )

    assert path_lengths(positions, RATE) == pytest.approx([0.5 * time[-1], 0.0], rel=1e-3, abs=1e-9)


def test_a_slow_circle_keeps_its_length() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, int(60 * RATE))
    positions = 4.0 * np.column_stack([np.cos(angle), np.sin(angle)])[:, None]

    assert path_lengths(positions, RATE)[0] == pytest.approx(2.0 * np.pi * 4.0, rel=2e-3)


def test_shaking_faster_than_the_cutoff_is_no_travel() -> None:
    time = np.arange(0.0, 60.0, 1.0 / RATE)
    shaking = np.column_stack([0.5 * time, 0.03 * np.sin(2.0 * np.pi * 8.0 * time)])[:, None]

    assert np.linalg.norm(np.diff(shaking[:, 0], axis=0), axis=1).sum() > 1.2 * 0.5 * time[-1]
    assert path_lengths(shaking, RATE)[0] == pytest.approx(0.5 * time[-1], rel=2e-3)


def test_a_record_of_one_sample_has_no_length() -> None:
    assert path_lengths(np.zeros((1, 3, 2)), 0.0).tolist() == [0.0, 0.0, 0.0]


def test_samples_too_sparse_for_the_low_pass_are_refused() -> None:
    with pytest.raises(ValueError, match="sample faster"):
        path_lengths(np.zeros((10, 1, 2)), 2.0)


@pytest.mark.parametrize("seed", range(5))
def test_the_bound_is_the_cheapest_permutation_within_each_type(seed: int) -> None:
    costs = rng_for(seed, "costs").uniform(1.0, 10.0, (6, 6))
    robot_types, goal_types = np.array([1, 1, 1, 2, 2, 2]), np.array([2, 1, 2, 1, 2, 1])

    bound = displacement_bound(costs, robot_types, goal_types)

    fitting = [p for p in itertools.permutations(range(6)) if (goal_types[list(p)] == robot_types).all()]
    cheapest = min(fitting, key=lambda p: costs[range(6), list(p)].sum())
    assert bound is not None
    assert bound.goal_of.tolist() == list(cheapest)
    assert bound.total == pytest.approx(costs[range(6), list(cheapest)].sum())
    assert bound.longest == pytest.approx(costs[range(6), list(cheapest)].max())


def test_a_robot_too_many_is_left_out_where_that_is_cheapest() -> None:
    bound = displacement_bound(np.array([[5.0], [2.0], [9.0]]), np.array([1, 1, 1]), np.array([1]))

    assert bound is not None
    assert (bound.total, bound.goal_of.tolist()) == (2.0, [-1, 0, -1])


def test_there_is_no_bound_where_a_robot_cannot_reach_any_goal() -> None:
    assert displacement_bound(np.array([[np.inf, np.inf], [1.0, 2.0]]), np.array([1, 1]), np.array([1, 1])) is None
