"""Descent for layouts: its slope is the cost's, and it closes what can be closed."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_agent.coverage.least_gaps import Gaps, closed
from swarm_msgs_py.randomness import rng_for

RADIUS, REACH = 1.0, 0.9
TAILS, HEADS = np.array([0, 1, 1]), np.array([1, 2, 3])


def gaps_of(cloud: np.ndarray) -> Gaps:
    return Gaps(cloud, 0.1, RADIUS, REACH, TAILS, HEADS)


def test_the_slope_of_the_model_is_that_of_the_cost() -> None:
    rng = rng_for(0, "gaps")
    places, gaps = rng.normal(size=(4, 3)), gaps_of(2.0 * rng.normal(size=(50, 3)))
    slope, bend = gaps.model(4, gaps.cost(places)[1])

    for row in range(12):
        nudge = np.zeros(12)
        nudge[row] = 1e-6
        up, down = (gaps.cost(places + sign * nudge.reshape(4, 3))[0] for sign in (1.0, -1.0))
        assert 2.0 * slope[row] == pytest.approx((up - down) / 2e-6, abs=1e-5)
    assert np.linalg.eigvalsh(bend).min() > -1e-9


def test_descent_closes_gaps_and_links_and_leaves_the_leader() -> None:
    cloud = np.stack([np.linspace(-0.9, 2.5, 60), np.zeros(60), np.zeros(60)], axis=1)
    start = np.array([[0.0, 0.0, 0.0], [0.5, 0.3, 0.0], [0.6, -0.2, 0.1], [1.1, 1.4, 0.0]])
    gaps = gaps_of(cloud)
    places = closed(gaps, start, 40)

    assert np.array_equal(places[0], start[0])
    assert gaps.cost(start)[0] > 0.1
    assert gaps.cost(places)[0] < 1e-4


def test_a_leader_alone_cannot_move() -> None:
    none = np.zeros(0, dtype=np.int64)
    gaps = Gaps(np.full((5, 3), 9.0), 0.1, RADIUS, REACH, none, none)

    assert np.array_equal(closed(gaps, np.zeros((1, 3)), 5), np.zeros((1, 3)))
