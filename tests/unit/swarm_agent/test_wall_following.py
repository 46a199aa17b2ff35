"""Sliding along a wall that the path leads into."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from swarm_agent.control.wall_following import WallFollowing

RADIUS, MARGIN, PERIOD = 0.15, 0.04, 0.5
NOTHING = np.empty((0, 2))


def wall_in(direction: tuple[float, float], distance: float) -> np.ndarray:
    return distance * np.array([direction])


def following() -> WallFollowing:
    return WallFollowing(RADIUS, MARGIN, PERIOD)


def test_without_a_wall_the_path_is_followed() -> None:
    assert_allclose(following().step(np.array([0.3, 0.4]), NOTHING), [0.3, 0.4])


def test_who_is_driven_into_a_wall_slides_along_it_at_full_speed() -> None:
    assert_allclose(following().step(np.array([0.3, 0.4]), wall_in((0, 1), 0.2)), [0.5, 0.0])
    assert_allclose(following().step(np.array([-0.3, 0.4]), wall_in((0, 1), 0.2)), [-0.5, 0.0])


@pytest.mark.parametrize(
    ("wanted", "distance"),
    [((0.5, 0.0), 0.2), ((0.3, -0.4), 0.2), ((0.0, 0.4), 0.5), ((0.0, 0.02), 0.21), ((0.0, 0.0), 0.2)],
    ids=["along it", "away from it", "not within this tick", "up to it", "at rest"],
)
def test_a_wall_that_is_not_in_the_way_changes_nothing(wanted: tuple[float, float], distance: float) -> None:
    assert_allclose(following().step(np.array(wanted), wall_in((0, 1), distance)), wanted)


def test_the_sense_is_kept_when_the_path_seems_to_lead_back() -> None:
    follow = following()
    follow.step(np.array([0.3, 0.4]), wall_in((0, 1), 0.2))

    assert_allclose(follow.step(np.array([-0.3, 0.4]), wall_in((0, 1), 0.2)), [0.5, 0.0])


def test_the_sense_is_forgotten_where_the_wall_ends() -> None:
    follow = following()
    follow.step(np.array([0.3, 0.4]), wall_in((0, 1), 0.2))
    follow.step(np.array([0.3, 0.4]), NOTHING)

    assert_allclose(follow.step(np.array([-0.3, 0.4]), wall_in((0, 1), 0.2)), [-0.5, 0.0])


def test_in_a_corner_the_nearer_wall_counts() -> None:
    walls = np.vstack([wall_in((0, 1), 0.20), wall_in((1, 0), 0.30)])

    assert_allclose(following().step(np.array([0.1, 0.4]), walls), [np.hypot(0.1, 0.4), 0.0])
