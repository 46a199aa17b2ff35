from itertools import pairwise

import numpy as np

from swarm_msgs_py.partition.quasi_newton import minimize
from swarm_msgs_py.partition.rounding import GRID
from swarm_msgs_py.types import FloatArray

CENTER = np.array([[0.25, -0.5], [1.0, 2.0]])
STIFFNESS = np.array([[1.0, 30.0], [4.0, 0.5]])


def bowl(points: FloatArray) -> tuple[float, FloatArray]:
    offsets = points - CENTER
    return float((STIFFNESS * offsets**2).sum()), 2.0 * STIFFNESS * offsets


def valley(points: FloatArray) -> tuple[float, FloatArray]:
    """Rosenbrock's function of each point."""
    x, y = points.T
    slope = np.column_stack([2.0 * (x - 1.0) - 400.0 * x * (y - x * x), 200.0 * (y - x * x)])
    return float(((1.0 - x) ** 2 + 100.0 * (y - x * x) ** 2).sum()), slope


def test_the_bottom_of_a_bowl_is_found_in_a_few_steps() -> None:
    found = minimize(bowl, np.array([[5.0, 5.0], [-5.0, 0.0]]), step_max=3.0, tolerance=1e-5, steps_max=30)

    np.testing.assert_allclose(found, CENTER, atol=1e-4)


def test_a_bent_valley_is_followed_to_its_end() -> None:
    found = minimize(valley, np.array([[-1.2, 1.0]]), step_max=0.5, tolerance=1e-6, steps_max=300)

    np.testing.assert_allclose(found, [[1.0, 1.0]], atol=1e-3)


def test_errors_in_the_last_bits_vanish() -> None:
    rng = np.random.default_rng(1)

    def noisy(points: FloatArray) -> tuple[float, FloatArray]:
        value, gradient = valley(points)
        return value * (1.0 + 1e-16 * rng.normal()), gradient * (1.0 + 1e-15 * rng.normal(size=gradient.shape))

    start = np.array([[-1.2, 1.0], [0.3, 0.4]])
    exact = minimize(valley, start, step_max=0.5, tolerance=1e-6, steps_max=40)

    np.testing.assert_array_equal(minimize(noisy, start, step_max=0.5, tolerance=1e-6, steps_max=40), exact)
    np.testing.assert_array_equal(exact * GRID, np.rint(exact * GRID))


def test_no_point_moves_farther_in_a_step_than_it_may() -> None:
    visited = []

    def watched(points: FloatArray) -> tuple[float, FloatArray]:
        visited.append(points)
        return bowl(points)

    minimize(watched, np.array([[50.0, 5.0], [-5.0, 0.0]]), step_max=0.7, tolerance=1e-5, steps_max=5)

    assert max(np.abs(b - a).max() for a, b in pairwise(visited)) <= 0.7 + 1.0 / GRID
