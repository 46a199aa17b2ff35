from __future__ import annotations

import numpy as np
import pytest
from arena import ELL, rectangle
from numpy.testing import assert_allclose

from swarm_sim.config import ProximityConfig
from swarm_sim.sensors.proximity import Proximity
from swarm_sim.world.obstacles import ObstacleField
from swarm_sim.world.world import BodyState

Points = list[tuple[float, float]]


def measure(
    places: Points,
    yaws: list[float] | None = None,
    obstacles: list[np.ndarray] | None = None,
    radii: list[float] | None = None,
    **settings: float,
) -> list[np.ndarray]:
    n = len(places)
    config = ProximityConfig(**({"sigma_m": 0.0} | settings))  # type: ignore[arg-type]
    sensor = Proximity(config, np.array(radii or [0.5] * n), ObstacleField(obstacles or []), seed=1)
    state = BodyState(np.array(places), np.zeros(n), np.array(yaws or [0.0] * n), np.zeros((n, 2)), np.zeros(n))
    return sensor.measure(0, state)


def test_a_robot_sees_the_near_side_of_others_in_its_own_frame() -> None:
    seen = measure([(0.0, 0.0), (2.0, 0.0)], yaws=[np.pi / 2.0, 0.0], radii=[0.15, 0.5])

    assert_allclose(seen[0], [(0.0, -1.5)], atol=1e-12)
    assert_allclose(seen[1], [(-1.85, 0.0)], atol=1e-12)


def test_the_range_counts_from_the_center_to_the_surface() -> None:
    assert len(measure([(0.0, 0.0), (3.49, 0.0)])[0]) == 1
    assert len(measure([(0.0, 0.0), (3.51, 0.0)])[0]) == 0


def test_both_walls_of_an_inner_corner_are_seen() -> None:
    seen = measure([(-1.0, -0.5)], obstacles=[ELL])[0]

    assert_allclose(seen, [(-1.0, 0.0), (0.0, -1.5)], atol=1e-12)


def test_points_come_nearest_first_and_the_farthest_are_left_out() -> None:
    ring = [(0.0, 0.0), *((1.0 + 0.1 * k, 0.0) for k in range(8))]

    seen = measure(ring, radii=[0.1] * 9, points_max=3)[0]

    assert_allclose(seen[:, 0], [0.9, 1.0, 1.1])


def test_a_wall_hides_what_is_behind_it() -> None:
    wall = rectangle(0.9, -2.0, 1.1, 2.0)

    seen = measure([(0.0, 0.0), (2.0, 0.0)], obstacles=[wall])

    assert_allclose(seen[0], [(0.9, 0.0)], atol=1e-12)
    assert_allclose(seen[1], [(-0.9, 0.0)], atol=1e-12)


def test_noise_is_small_and_zero_mean() -> None:
    config = ProximityConfig(sigma_m=0.005)
    sensor = Proximity(config, np.array([0.5, 0.5]), ObstacleField([]), seed=1)
    state = BodyState(np.array([(0.0, 0.0), (2.0, 0.0)]), np.zeros(2), np.zeros(2), np.zeros((2, 2)), np.zeros(2))

    record = np.array([sensor.measure(k, state)[0][0] for k in range(1000)])

    assert_allclose(record.mean(axis=0), [1.5, 0.0], atol=1e-3)
    assert_allclose(record.std(axis=0), 0.005, rtol=0.1)


def test_overlapping_robots_still_see_each_other() -> None:
    seen = measure([(0.0, 0.0), (0.2, 0.0)])

    assert_allclose(seen[0], [(0.0, 0.0)], atol=1e-12)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
def test_what_is_seen_does_not_depend_on_who_is_listed_first(order: tuple[int, ...]) -> None:
    places = [(0.0, 0.0), (1.5, 0.0), (0.0, 1.5)]

    seen = measure([places[k] for k in order])[order.index(0)]

    assert_allclose(seen, [(0.0, 1.0), (1.0, 0.0)], atol=1e-12)
