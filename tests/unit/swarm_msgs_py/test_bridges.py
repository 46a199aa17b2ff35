"""Shapes of several parts as one contour."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from shapely import Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.bridges import BRIDGE_M, bridged, split
from swarm_msgs_py.geometry.contour import signed_area

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
U_SHAPE = np.array([[0, 0], [9, 0], [9, 6], [6, 6], [6, 1], [3, 1], [3, 6], [0, 6]], dtype=float)
RIGHT, UP = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def test_a_split_has_two_halves_of_equal_area_the_gap_apart_and_nothing_else() -> None:
    contour = split(SQUARE, 0.0, 3.0)

    left = Polygon(contour).intersection(Polygon([(-9, -9), (0.5, -9), (0.5, 9), (-9, 9)]))
    assert Polygon(contour).is_valid
    assert signed_area(contour) == pytest.approx(16.0 + 3.0 * BRIDGE_M, abs=1e-6)
    assert left.area == pytest.approx(8.0, abs=1e-6)
    assert_allclose(Polygon(contour).bounds, [-1.5, 0.0, 5.5, 4.0], atol=1e-9)
    assert_allclose(sorted(set(contour[:, 0].round(9))), [-1.5, 0.5, 3.5, 5.5])


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5])
@pytest.mark.parametrize("name", ["formation_1", "formation_3"])
def test_library_shapes_split_in_any_direction(name: str, direction: float) -> None:
    whole = load_shape(name)

    contour = split(whole, direction, 5.0)

    halves = Polygon(contour).buffer(-BRIDGE_M)
    areas = sorted(part.area for part in halves.geoms)
    assert Polygon(contour).is_valid
    assert len(areas) == 2
    assert areas[1] - areas[0] < 0.01 * signed_area(whole)
    assert halves.geoms[0].distance(halves.geoms[1]) >= 5.0


def test_a_cut_through_two_arms_is_refused() -> None:
    with pytest.raises(ShapeError, match="more than two pieces; cut in another direction"):
        split(U_SHAPE, np.pi / 2.0, 2.0)


def test_three_parts_become_one_contour() -> None:
    contour = bridged([SQUARE, SQUARE + 6.0 * RIGHT, SQUARE + 6.0 * RIGHT + 7.0 * UP])

    assert Polygon(contour).is_valid
    assert signed_area(contour) == pytest.approx(48.0 + 5.0 * BRIDGE_M, abs=1e-3)


def test_one_part_stays_what_it_is() -> None:
    assert Polygon(bridged([SQUARE])).equals(Polygon(SQUARE))


def test_parts_that_touch_are_refused() -> None:
    with pytest.raises(ShapeError, match="move them apart"):
        bridged([SQUARE, SQUARE + 4.0 * RIGHT])


def test_a_part_may_lie_in_the_bay_of_another() -> None:
    contour = bridged([U_SHAPE, SQUARE / 8.0 + np.array([4.25, 4.0])])

    assert Polygon(contour).is_valid
    assert signed_area(contour) == pytest.approx(39.25 + 1.25 * BRIDGE_M, abs=1e-3)
