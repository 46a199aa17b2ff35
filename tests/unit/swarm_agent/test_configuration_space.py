from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from oracles_planning import grown_by_triangles
from shapely.geometry import Point, Polygon

from swarm_agent.planning.configuration_space import ConfigurationSpace, disc_polygon
from swarm_msgs_py.errors import ShapeError

SQUARE = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])
ELL = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 2.0), (2.0, 2.0), (2.0, 9.0), (0.0, 9.0)])
DISC = disc_polygon(0.6, 16)


def test_the_circumscribed_polygon_holds_the_circle_and_the_inscribed_one_lies_in_it():
    outer, inner = Polygon(disc_polygon(2.0, 16)), Polygon(disc_polygon(2.0, 16, inscribed=True))
    center = Point(0.0, 0.0)
    assert outer.exterior.distance(center) == pytest.approx(2.0)
    assert inner.exterior.hausdorff_distance(center) == pytest.approx(2.0)
    assert len(outer.exterior.coords) == len(inner.exterior.coords) == 17


def test_a_wall_along_an_axis_grows_by_exactly_the_radius():
    space = ConfigurationSpace((SQUARE,), DISC)
    assert space.forbidden.bounds == pytest.approx((-0.6, -0.6, 4.6, 4.6), abs=1e-7)


def test_a_grown_square_has_the_area_of_steiners_formula():
    space = ConfigurationSpace((SQUARE,), DISC)
    assert space.forbidden.area == pytest.approx(16.0 + 4 * 4.0 * 0.6 + Polygon(DISC).area, abs=1e-6)


def test_a_concave_obstacle_keeps_its_notch():
    space = ConfigurationSpace((ELL,), DISC)
    assert space.forbidden.symmetric_difference(grown_by_triangles((ELL,), DISC)).area < 1e-6
    assert space.is_free(np.array([2.7, 2.7]))
    assert not space.is_free(np.array([2.5, 2.7]))


def test_the_direction_of_an_outline_does_not_matter():
    for polygon in (SQUARE, ELL):
        one, other = (ConfigurationSpace((outline,), DISC) for outline in (polygon, polygon[::-1]))
        assert one.forbidden.symmetric_difference(other.forbidden).area < 1e-6


def test_overlapping_obstacles_merge_into_one_outline():
    space = ConfigurationSpace((SQUARE, SQUARE + np.array((4.5, 0.0)), SQUARE + np.array((20.0, 0.0))), DISC)
    assert len(space.rings) == 2
    assert not space.is_free(np.array([4.25, 2.0]))


def test_a_ring_of_obstacles_encloses_a_hole_whose_outline_runs_the_other_way():
    walls = tuple(np.array(shapely.box(*box).exterior.coords)[:-1] for box in
                  [(-5, -5, 5, -4), (-5, 4, 5, 5), (-5, -5, -4, 5), (4, -5, 5, 5)])  # fmt: skip
    space = ConfigurationSpace(walls, DISC)
    assert len(space.rings) == 2
    areas = [float(np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1))) / 2.0
             for ring in space.rings]  # fmt: skip
    assert sorted(areas) == pytest.approx([-(6.8**2), 11.2**2 - (1.2**2 - Polygon(DISC).area)], abs=1e-5)
    assert space.is_free(np.zeros(2))
    assert not space.is_free(np.array([4.5, 0.0]))


def test_a_post_and_a_thin_wall_are_obstacles_too():
    space = ConfigurationSpace((np.array([(0.0, 0.0)]), np.array([(5.0, 0.0), (9.0, 0.0)])), DISC)
    assert space.forbidden.area == pytest.approx(2.0 * Polygon(DISC).area + 4.0 * 1.2, abs=1e-6)
    assert not space.is_free(np.array([0.0, 0.5]))
    assert not space.is_free(np.array([7.0, -0.5]))


def test_a_self_crossing_outline_blocks_at_least_its_lines_and_its_area():
    bow_tie = np.array([(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0)])
    space = ConfigurationSpace((bow_tie,), DISC)
    assert not space.is_free(np.array([3.8, 2.0]))
    assert not space.is_free(np.array([2.0, 2.0]))
    assert space.is_free(np.array([2.0, 3.9]))


def test_points_on_the_boundary_are_free_and_stay_where_they_are():
    space = ConfigurationSpace((SQUARE,), DISC)
    for point in [np.array([-0.6, 2.0]), space.rings[0][0], space.rings[0][3:5].mean(axis=0)]:
        assert space.is_free(point)
        assert np.array_equal(space.project(point), point)


def test_a_point_inside_moves_straight_out_over_the_nearest_edge():
    space = ConfigurationSpace((SQUARE,), DISC)
    assert space.project(np.array([-0.4, 1.0])) == pytest.approx([-0.6, 1.0])
    assert space.project(np.array([2.5, 4.1])) == pytest.approx([2.5, 4.6])


def test_nothing_is_forbidden_without_obstacles():
    space = ConfigurationSpace((), DISC)
    assert space.rings == ()
    assert space.is_free(np.zeros(2))
    assert space.project(np.ones(2)).tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    "obstacle", [np.empty((0, 2)), np.zeros(4), np.zeros((3, 3)), np.array([(0.0, math.nan), (1, 0), (1, 1)])]
)
def test_what_is_no_list_of_points_is_refused_by_its_number(obstacle):
    with pytest.raises(ShapeError, match="obstacle 1 is not a list of finite points"):
        ConfigurationSpace((SQUARE, obstacle), DISC)
