import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracles_contour import summed_obstacle

from swarm_agent.forces.obstacle_integral import ObstacleIntegral
from swarm_msgs_py.types import FloatArray

BLOCK = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]])
TRIANGLE = np.array([[-3.0, 2.0], [-1.0, 2.5], [-2.5, 4.0]])
OUTLINES = (BLOCK, TRIANGLE)
GAP_MIN = 0.1


def push_on(point: tuple[float, float], radius: float) -> FloatArray:
    return ObstacleIntegral(OUTLINES, GAP_MIN).at(np.array([point]), np.array([radius]))[0]


@pytest.mark.parametrize("radius", [0.05, 0.15, 0.5])
@pytest.mark.parametrize(
    "point",
    [
        pytest.param((2.0, 3.0), id="before an edge"),
        pytest.param((5.0, 1.8), id="around a corner"),
        pytest.param((6.0, 0.7), id="before a short edge"),
        pytest.param((-1.2, 0.0), id="on the line of an edge"),
        pytest.param((-1.2, -0.03), id="beside the line of an edge, nearer than the radius"),
        pytest.param((40.0, -30.0), id="far away"),
    ],
)
def test_the_closed_form_is_the_limit_of_the_sum(point: tuple[float, float], radius: float) -> None:
    expected = summed_obstacle(OUTLINES, np.array(point), radius, GAP_MIN, 1e-3)

    assert_allclose(push_on(point, radius), expected, rtol=1e-5)


@pytest.mark.parametrize("point", [(2.0, 1.55), (2.0, 1.3), (-0.2, 0.6), (4.3, 1.3)])
def test_a_gap_below_the_least_one_counts_as_the_least_one(point: tuple[float, float]) -> None:
    expected = summed_obstacle(OUTLINES, np.array(point), 0.5, GAP_MIN, 1e-4)

    assert_allclose(push_on(point, 0.5), expected, rtol=1e-4)


@pytest.mark.parametrize("radius", [0.05, 0.3, 0.5])
@pytest.mark.parametrize("shift", [0.0, 1e-9, -1e-7, 1e-5, -1e-4])
def test_a_line_that_touches_the_coverage_circle_costs_less_than_a_percent(radius: float, shift: float) -> None:
    point = (-0.5 * radius - 0.6, -radius + shift)

    expected = summed_obstacle(OUTLINES, np.array(point), radius, GAP_MIN, 1e-3)

    assert np.linalg.norm(push_on(point, radius) - expected) < 0.01 * np.linalg.norm(expected)


def test_a_long_wall_at_one_meter_pushes_as_the_specification_says() -> None:
    wall = np.array([[-500.0, -0.01], [500.0, -0.01], [500.0, 0.0], [-500.0, 0.0]])
    push = ObstacleIntegral((wall,), GAP_MIN).at(np.array([[0.0, 1.0]]), np.array([0.15]))

    # A thin wall has two faces; spec 8.2 gives 1.4e4 for one, with the gain of 5000.
    assert_allclose(5000.0 * push / 2.0, [[0.0, 1.4e4]], rtol=0.1, atol=1e-6)


def test_without_obstacles_there_is_no_push() -> None:
    push = ObstacleIntegral((), GAP_MIN).at(np.array([[1.0, 2.0], [0.0, 0.0]]), np.array([0.3, 0.5]))

    assert_allclose(push, np.zeros((2, 2)))


def test_many_robots_at_once_feel_what_each_feels_alone() -> None:
    rng = np.random.default_rng(5)
    points, radii = rng.uniform(-4.0, 8.0, (40, 2)), rng.choice([0.15, 0.3, 0.5], 40)

    together = ObstacleIntegral(OUTLINES, GAP_MIN).at(points, radii)

    alone = np.array([push_on((x, y), radius) for (x, y), radius in zip(points, radii, strict=True)])
    assert_allclose(together, alone, rtol=1e-9, atol=1e-9)
