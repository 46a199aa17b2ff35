"""Collision avoidance over generated crowds: the safety rule holds wherever robots stand and want to go."""

from __future__ import annotations

import numpy as np
from crowd import move_crowd
from hypothesis import given, settings
from hypothesis import strategies as st

RADII = np.array([0.15, 0.3, 0.5])
SPACING = 1.2  # of the grid that robots start from: the largest ones have a free gap of 0.2 m


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), robots=st.integers(2, 9), crowding=st.floats(0.2, 3.0))
def test_no_two_circles_ever_overlap(seed: int, robots: int, crowding: float) -> None:
    rng = np.random.default_rng(seed)
    places = np.array([[i, j] for i in range(3) for j in range(3)]) * SPACING
    starts = places[rng.permutation(9)[:robots]]
    goals = rng.uniform(-crowding, crowding, (robots, 2))  # mostly too close to each other to be held by all

    result = move_crowd(starts, goals, RADII[rng.integers(0, 3, robots)], deadline=25.0, seed=seed)

    assert result.min_gap > 0.0
