import numpy as np
import pytest
from numpy.testing import assert_allclose
from shapely import Point, Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.partition.free_region import free_region

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])


def test_a_square_shrinks_by_radius_and_gap() -> None:
    region = free_region(SQUARE, (), 1.0, 0.5, 0.1)

    inside = region.contains(np.array([[5.0, 5.0], [1.6, 5.0], [1.4, 5.0], [11.0, 5.0]]))

    assert inside.tolist() == [True, True, False, False]


def test_points_outside_move_to_the_nearest_boundary_point_and_others_stay() -> None:
    region = free_region(SQUARE, (), 1.0, 0.5, 0.1)

    moved, room = region.project(np.array([[5.0, -3.0], [-2.0, -2.0], [5.0, 4.0]]))

    assert_allclose(moved, [[5.0, 1.5], [1.5, 1.5], [5.0, 4.0]], atol=0.02)
    assert_allclose(room, [0.0, 0.0, 2.5], atol=0.02)


def test_one_point_has_the_same_nearest_point_as_among_many() -> None:
    region = free_region(load_shape("formation_2"), (), 0.3, 0.0, 0.1)
    center = region.starts.mean(axis=0)
    points = center + np.random.default_rng(2).uniform(-15.0, 15.0, (40, 2))

    moved, _ = region.project(points)

    assert 5 < int((moved == points).all(axis=1).sum()) < 35
    assert_allclose([region.nearest(point) for point in points], moved, atol=1e-12)


def test_an_obstacle_beside_the_shape_takes_room_inside() -> None:
    wall = np.array([[10.1, 4.0], [11.0, 4.0], [11.0, 6.0], [10.1, 6.0]])
    region = free_region(SQUARE, (wall,), 1.0, 0.2, 1.0)

    assert region.contains(np.array([[8.0, 5.0], [8.2, 5.0], [8.2, 1.5]])).tolist() == [True, False, True]


def test_a_shape_narrower_than_the_circle_leaves_nothing() -> None:
    assert free_region(SQUARE, (), 5.1, 0.1, 0.1).is_empty


@pytest.mark.parametrize("name", ["formation_2", "hw_4_arrow", "iso_4_free"])
def test_the_region_keeps_its_distance_from_the_contour_at_every_vertex(name: str) -> None:
    contour = load_shape(name)
    radius = 0.05
    region = free_region(contour, (), radius, 0.02, 0.1)

    middles = 0.5 * (region.starts + region.ends)
    border = Polygon(contour).exterior

    assert min(border.distance(Point(point)) for point in middles) >= radius + 0.02 - 1e-9
