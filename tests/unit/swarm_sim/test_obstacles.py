from __future__ import annotations

import numpy as np
import pytest
from arena import ELL, rectangle
from numpy.testing import assert_allclose
from shapely import Polygon

from swarm_sim.world.obstacles import ObstacleField, convex_pieces

BLOCK = rectangle(0.0, 0.0, 2.0, 1.0)


def test_signed_distance_is_negative_inside() -> None:
    points = np.array([(1.0, 0.5), (3.0, 0.5), (3.0, 2.0), (1.0, -0.25)])

    distances = ObstacleField([BLOCK]).signed_distances(points, 0)

    assert_allclose(distances, [-0.5, 1.0, np.sqrt(2.0), 0.25])


def test_orientation_of_the_corners_does_not_matter() -> None:
    points = np.array([(-3.0, -3.0), (0.0, 0.0), (9.0, 1.0)])

    there, back = ObstacleField([ELL]), ObstacleField([ELL[::-1]])

    assert_allclose(there.signed_distances(points, 0), back.signed_distances(points, 0))
    assert_allclose(there.facing_points(points, 20.0)[1], back.facing_points(points, 20.0)[1])


def test_an_inner_corner_shows_both_walls() -> None:
    observers, surface = ObstacleField([ELL]).facing_points(np.array([(-1.0, -0.5)]), 3.0)

    assert observers.tolist() == [0, 0]
    assert sorted(map(tuple, surface.tolist())) == [(-2.0, -0.5), (-1.0, -2.0)]


def test_a_straight_wall_and_an_outer_corner_show_one_point_each() -> None:
    observers, surface = ObstacleField([BLOCK]).facing_points(np.array([(1.0, 2.0), (3.0, 2.0)]), 3.0)

    assert observers.tolist() == [0, 1]
    assert_allclose(surface, [(1.0, 1.0), (2.0, 1.0)])


def test_what_is_out_of_reach_is_not_seen() -> None:
    observers, surface = ObstacleField([BLOCK]).facing_points(np.array([(1.0, 4.1)]), 3.0)

    assert observers.size == 0
    assert surface.shape == (0, 2)


@pytest.mark.parametrize(
    ("start", "end", "is_blocked"),
    [
        ((-1.0, 0.5), (3.0, 0.5), True),
        ((-1.0, 2.0), (3.0, 2.0), False),
        ((-1.0, 1.5), (1.0, 3.0), False),
        ((-1.0, -1.0), (3.0, 3.0), True),  # through a corner's diagonal
        ((-2.0, 1.0), (-1.0, 1.0), False),  # on the line of an edge, but short of it
        ((-2.0, 1.0), (3.0, 1.0), True),  # along an edge
    ],
)
def test_a_segment_is_blocked_where_it_touches_an_obstacle(
    start: tuple[float, float], end: tuple[float, float], is_blocked: bool
) -> None:
    assert ObstacleField([BLOCK]).is_blocked(np.array([start]), np.array([end]))[0] == is_blocked


def test_a_segment_on_the_line_of_another_wall_of_the_same_obstacle_is_free() -> None:
    # The upper side of the L's foot lies on y = -2; this segment lies on the line of the arm's top, y = 4, beside it.
    assert not ObstacleField([ELL]).is_blocked(np.array([(-1.0, 4.0)]), np.array([(3.0, 4.0)]))[0]


def test_a_field_without_obstacles_blocks_and_shows_nothing() -> None:
    field = ObstacleField([])

    assert not field.is_blocked(np.zeros((1, 2)), np.ones((1, 2)))[0]
    assert field.facing_points(np.zeros((1, 2)), 5.0)[0].size == 0
    assert field.box_distances(np.zeros((3, 2))).shape == (3, 0)


def test_a_convex_polygon_is_one_piece() -> None:
    hexagon = np.array([(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3.0])

    assert len(convex_pieces(hexagon)) == 1


def test_an_ell_is_two_convex_pieces_that_cover_it() -> None:
    pieces = [Polygon(piece) for piece in convex_pieces(ELL)]

    assert len(pieces) == 2
    assert sum(piece.area for piece in pieces) == pytest.approx(Polygon(ELL).area)
    assert all(piece.convex_hull.area == pytest.approx(piece.area) for piece in pieces)
