from __future__ import annotations

import numpy as np
import pytest
from arena import rectangle

from swarm_sim.world.clearance import clearance
from swarm_sim.world.obstacles import ObstacleField

RADII = np.array([0.15, 0.3, 0.5])


def line(*waypoints: tuple[float, float]) -> np.ndarray:
    return np.array(waypoints)


def test_the_smallest_gap_of_the_tick_counts() -> None:
    start = line((0.0, 0.0), (5.0, 0.0), (0.0, 9.0))
    samples = np.stack([line((2.0, 0.0), (4.0, 0.0), (0.0, 9.0)), line((0.0, 0.0), (5.0, 0.0), (0.0, 9.0))])

    found = clearance(start, samples, RADII, ObstacleField([]))

    assert found.min_gap == pytest.approx(2.0 - 0.45)
    assert found.robot_overlaps == ()


def test_an_overlap_in_passing_is_found_and_named() -> None:
    start = line((-1.0, 0.1), (1.0, 0.0), (0.0, 9.0))
    samples = np.stack([line((0.0, 0.1), (0.0, 0.0), (0.0, 9.0)), line((1.0, 0.1), (-1.0, 0.0), (0.0, 9.0))])

    found = clearance(start, samples, RADII, ObstacleField([]))

    assert found.min_gap == pytest.approx(0.1 - 0.45)
    assert found.robot_overlaps == ((0, 1),)


def test_walls_count_like_robots() -> None:
    field = ObstacleField([rectangle(20.0, 20.0, 21.0, 21.0), rectangle(1.0, -1.0, 2.0, 1.0)])
    start = line((0.0, 0.0), (5.0, 0.0), (0.0, 9.0))

    beside = clearance(start, start[None], RADII, field)
    inside = clearance(start, line((0.9, 0.0), (5.0, 0.0), (0.0, 9.0))[None], RADII, field)

    assert beside.min_gap == pytest.approx(1.0 - 0.15)
    assert beside.obstacle_overlaps == ()
    assert inside.min_gap == pytest.approx(0.1 - 0.15)
    assert inside.obstacle_overlaps == ((0, 1),)


def test_all_overlaps_are_named_not_only_the_deepest() -> None:
    start = line((0.0, 0.0), (0.4, 0.0), (1.0, 0.0))

    assert clearance(start, start[None], RADII, ObstacleField([])).robot_overlaps == ((0, 1), (1, 2))


def test_a_lone_robot_on_free_ground_has_infinite_clearance() -> None:
    assert clearance(np.zeros((1, 2)), np.zeros((1, 1, 2)), RADII[:1], ObstacleField([])).min_gap == np.inf
