"""Invariants of expansion (spec section 6): packing, tree edges, and a frontier store that equals recomputation."""

from __future__ import annotations

import numpy as np
import pytest
from coverage_shapes import BEAM, CROSS, EXPERIMENTS, nearest_pair
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.coverage.config import CoverageConfig, Rule, Samples
from swarm_agent.coverage.expansion import expand
from swarm_agent.coverage.frontier import Frontier
from swarm_agent.coverage.sense_sphere import directions_of, fibonacci_directions
from swarm_agent.coverage.store import FrontierStore
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray

DIRECTIONS = fibonacci_directions(150)
seeds = st.integers(min_value=0, max_value=2**31)


def recomputed(positions: FloatArray, radius: float) -> BoolArray:
    """Return from scratch which samples are in the shape and farther than the radius from all other robots."""
    points = positions[:, None] + radius * DIRECTIONS
    is_open = CROSS.contains(points.reshape(-1, 3)).reshape(points.shape[:2])
    distances = np.linalg.norm(points[:, :, None] - positions, axis=3)
    distances[np.arange(len(positions)), :, np.arange(len(positions))] = np.inf
    return is_open & (distances.min(axis=2) > radius * (1.0 + 1e-6))


@given(seeds)
@settings(max_examples=15)
def test_the_store_equals_recomputation_after_each_robot(seed: int) -> None:
    rng = rng_for(seed, "places")
    places = np.array([150.0, 40.0, 100.0]) * rng.uniform(-1.0, 1.0, size=(12, 3))
    store = FrontierStore(DIRECTIONS, 50.0, CROSS)

    for count, place in enumerate(places, start=1):
        store.enable(place)
        assert np.array_equal(store.is_open, recomputed(places[:count], 50.0))


@given(seeds)
@settings(max_examples=15)
def test_frontiers_that_only_hear_of_close_robots_equal_the_store(seed: int) -> None:
    rng = rng_for(seed, "places")
    places = np.array([150.0, 40.0, 100.0]) * rng.uniform(-1.0, 1.0, size=(12, 3))
    frontiers: list[Frontier] = []

    for count, place in enumerate(places):
        offsets = places[:count] - place
        close = np.linalg.norm(offsets, axis=1) < 100.0
        for robot in np.flatnonzero(close):
            frontiers[robot].delete_within(-offsets[robot])
        frontiers.append(Frontier.around(place, DIRECTIONS, 50.0, CROSS, offsets[close]))

    expected = recomputed(places, 50.0)
    for frontier, is_open in zip(frontiers, expected, strict=True):
        assert np.array_equal(frontier.samples, np.flatnonzero(is_open))
        assert frontier.size == len(frontier.points)


@given(seeds, st.sampled_from([Rule.RANDOM, Rule.FIRST]), st.sampled_from(Samples))
@settings(max_examples=12)
def test_exact_placement_on_the_frontier_is_a_packing(seed: int, rule: Rule, samples: Samples) -> None:
    config = CoverageConfig(rule=rule, samples=samples, placement=1.0)
    layout = expand(BEAM, np.zeros(3), config, 200, rng_for(seed, "expand"))

    assert nearest_pair(layout.positions) >= 50.0 * (1.0 - 1e-9)
    assert layout.edge_lengths == pytest.approx(50.0)


@given(seeds, st.sampled_from(sorted(EXPERIMENTS)), st.sampled_from([0.9, 0.95]))
@settings(max_examples=12)
def test_links_to_parents_are_strict_and_no_frontier_is_left(seed: int, name: str, placement: float) -> None:
    solid, radius = EXPERIMENTS[name]
    config = CoverageConfig(range_m=radius, rule=Rule.RANDOM, placement=placement)
    layout = expand(solid, np.zeros(3), config, 200, rng_for(seed, "expand"))

    store = FrontierStore(directions_of(config), radius, solid)
    for place in layout.positions:
        store.enable(place)
    assert layout.edge_lengths.max() < radius
    assert not store.is_open.any()
    assert len(layout.positions) <= 46
