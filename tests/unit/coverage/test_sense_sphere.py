"""Samples of sense spheres: the paper's grid and the even spread."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_agent.coverage.sense_sphere import covered_samples, fibonacci_directions, grid_directions
from swarm_msgs_py.randomness import rng_for


def test_the_papers_grid_has_182_distinct_points_of_400() -> None:
    directions = grid_directions()

    distances = np.linalg.norm(directions[:, None] - directions, axis=2)
    assert len(directions) == 182
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1.0)
    assert distances[np.triu_indices(182, k=1)].min() > 1e-3
    assert sorted({round(z, 9) for z in directions[:, 2]}) == pytest.approx(np.sin(np.pi * np.arange(-5, 6) / 10))


@pytest.mark.parametrize("axis", [*np.eye(3), *-np.eye(3)])
def test_the_papers_grid_holds_the_axes(axis: np.ndarray) -> None:
    assert np.linalg.norm(grid_directions() - axis, axis=1).min() < 1e-12


def test_a_fibonacci_sphere_is_even() -> None:
    directions = fibonacci_directions(400)
    distances = np.linalg.norm(directions[:, None] - directions, axis=2) + 9.0 * np.eye(400)

    nearest = distances.min(axis=1)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1.0)
    assert np.linalg.norm(directions.mean(axis=0)) < 1e-3
    assert nearest.max() / nearest.min() < 1.6


def test_covered_samples_are_those_within_the_radius() -> None:
    directions, radius = fibonacci_directions(200), 50.0
    offsets = 40.0 * rng_for(0, "offsets").normal(size=(30, 3))

    covered = covered_samples(directions, radius, offsets)

    distances = np.linalg.norm(radius * directions[:, None] - offsets, axis=2)
    assert np.array_equal(covered, distances <= radius * (1.0 + 1e-6))


def test_a_sample_at_exactly_the_radius_counts_as_covered() -> None:
    # I14: directions of the grid are 60 degrees from others, so that their points are one radius apart.
    covered = covered_samples(np.array([[1.0, 0.0, 0.0]]), 50.0, 50.0 * np.array([[0.5, np.sqrt(0.75), 0.0]]))

    assert covered.all()
