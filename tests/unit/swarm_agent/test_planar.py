"""Vectors of two components: the quick length is NumPy's, to the last digit."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_agent.planar import length_of


def test_a_length_is_that_of_numpy_to_the_last_digit() -> None:
    rng = np.random.default_rng(7)
    vectors = rng.normal(size=(2000, 2)) * np.exp(4.0 * rng.normal(size=(2000, 2)))
    assert [length_of(vector) for vector in vectors] == np.hypot(vectors[:, 0], vectors[:, 1]).tolist()


@pytest.mark.parametrize("vector", [(0.0, 0.0), (-0.0, 0.0), (1e-300, 1e-300), (0.0, -3.0)])
def test_a_length_at_the_edges_of_the_numbers_is_that_of_numpy(vector: tuple[float, float]) -> None:
    assert length_of(np.array(vector)) == float(np.hypot(*vector))
