"""The goals that receivers of a plan find for themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from shapely import Point, Polygon

from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.partition import Method, PartitionConfig, partition
from swarm_msgs_py.plan_goals import completed, goals_crc, is_contour
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray

SQUARE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]])
BOW_TIE, SLIVER = SQUARE[[0, 2, 1, 3]], np.array([[0.0, 0.0], [5.0, 0.0], [9.0, 0.0]])
BODY = SQUARE / 6.0 + 2.5
ROSTER = Roster.of([THESIS_TYPES[0]] * 4 + [THESIS_TYPES[2]] * 2)
CONFIG = PartitionConfig()


def order(method: Method = Method.VORONOI, contour: FloatArray = SQUARE, bodies: tuple[FloatArray, ...] = ()) -> Plan:
    """Return a plan to partition a shape, as it is received."""
    nowhere, nobody = np.empty((0, 2)), np.empty(0, dtype=np.int64)
    plan = Plan(1, contour, bodies, nowhere, nobody, len(bodies), Task.PARTITION, ROSTER, method)
    received = decode_body(encode_body(plan))
    assert isinstance(received, Plan)
    return received


@pytest.mark.parametrize("method", list(Method))
def test_the_goals_are_those_of_the_method_in_whole_centimeters(method: Method) -> None:
    found = completed(order(method), CONFIG)

    expected = partition(SQUARE, ROSTER, (), replace(CONFIG, method=method))
    assert_array_equal(found.goals, expected.positions.round(2))
    assert_array_equal(found.goal_types, expected.types)
    assert (found.epoch, found.task, found.roster) == (1, Task.PARTITION, ROSTER)


def test_what_has_been_found_is_sent_on_as_it_came() -> None:
    plan = order()

    assert encode_body(completed(plan, CONFIG)) == encode_body(plan)
    assert_array_equal(completed(completed(plan, CONFIG), CONFIG).goals, completed(plan, CONFIG).goals)


def test_goals_keep_away_from_bodies() -> None:
    found = completed(order(bodies=(BODY,)), CONFIG)

    radii = ROSTER.radii_of(found.goal_types)
    gaps = [Polygon(BODY).distance(Point(goal)) - radius for goal, radius in zip(found.goals, radii, strict=True)]
    assert min(gaps) >= CONFIG.gaps.obstacle_m - 0.01
    assert min(Polygon(BODY).distance(Point(goal)) for goal in completed(order(), CONFIG).goals) < min(gaps)


def test_plans_that_leave_nothing_to_find_stay_as_they_are() -> None:
    forces = replace(order(), task=Task.FORCES, method=None)

    assert completed(forces, CONFIG) is forces


@pytest.mark.parametrize(
    "contour", [SQUARE * 0.1, BOW_TIE, SQUARE[::-1], SLIVER, SQUARE[:2], SQUARE[:0]],
    ids=["small", "crossing", "clockwise", "flat", "line", "nothing"],
)  # fmt: skip
def test_what_cannot_be_partitioned_is_refused(contour: FloatArray) -> None:
    with pytest.raises(ShapeError):
        completed(order(contour=contour), CONFIG)


def test_obstacles_that_are_none_are_refused() -> None:
    with pytest.raises(ShapeError, match="cannot be partitioned"):
        completed(replace(order(bodies=(BODY,)), obstacles=(BODY[:1],)), CONFIG)


def test_the_checksum_tells_centimeters_and_types_apart_but_not_less() -> None:
    goals, types = np.array([[1.0, 2.0], [3.0, -4.0]]), np.array([1, 2])
    crc = goals_crc(goals, types)

    assert goals_crc(goals + 0.004, types) == crc
    assert goals_crc(goals + 0.01, types) != crc
    assert goals_crc(goals[::-1], types) != crc
    assert goals_crc(goals, types[::-1]) != crc
    assert goals_crc(goals[:0], types[:0]) == 0


def test_a_contour_is_simple_and_counter_clockwise() -> None:
    assert is_contour(SQUARE)
    assert not any(map(is_contour, (BOW_TIE, SQUARE[::-1], SLIVER, SQUARE[:2], SQUARE[:0])))
