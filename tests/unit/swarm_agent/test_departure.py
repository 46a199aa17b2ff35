"""Where a robot sets out for while nobody knows yet who takes which goal."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from swarm_agent.decision.departure import AGREEMENT_MIN, early_destination

GOALS = np.array([[-4.0, -2.0], [4.0, -2.0], [0.0, 0.0], [4.0, 3.0], [-4.0, 3.0]])


def test_far_away_all_goals_lie_in_about_one_direction_so_it_sets_out() -> None:
    destination = early_destination(np.array([40.0, 0.0]), GOALS)

    assert destination is not None
    assert_array_equal(destination, [0.0, 0.0])


@pytest.mark.parametrize("position", [(0.0, 0.5), (4.0, -2.0), (0.0, -3.0)])
def test_inside_or_beside_the_shape_any_direction_may_be_wrong(position: tuple[float, float]) -> None:
    assert early_destination(np.array(position), GOALS) is None


def test_beside_a_long_shape_the_nearest_goal_is_no_guide() -> None:
    line = np.column_stack([np.linspace(-20.0, 20.0, 9), np.zeros(9)])

    assert early_destination(np.array([0.0, -8.0]), line) is None


def test_without_goals_of_its_type_there_is_nowhere_to_go() -> None:
    assert early_destination(np.zeros(2), np.empty((0, 2))) is None


@given(st.floats(0.0, 2.0 * np.pi), st.floats(0.1, 80.0))
def test_whatever_the_goal_will_be_the_way_was_not_much_longer_on_the_average(angle: float, distance: float) -> None:
    position = distance * np.array([np.cos(angle), np.sin(angle)])
    destination = early_destination(position, GOALS)
    if destination is None:
        return
    before = np.linalg.norm(GOALS - position, axis=1)
    step = min(0.1, 0.5 * float(before.min()))
    way = destination - position
    after = np.linalg.norm(GOALS - position - step * way / np.linalg.norm(way), axis=1)

    assert (before - after).mean() >= 0.9 * AGREEMENT_MIN * step
