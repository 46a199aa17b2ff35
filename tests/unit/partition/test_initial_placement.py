import numpy as np
import pytest
from shapely import Point, Polygon
from shapely.ops import nearest_points

from mission_computer.shape import load_shape
from swarm_msgs_py.partition.config import Gaps
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.initial_placement import place, shortage
from swarm_msgs_py.types import FloatArray

GAPS = Gaps(robot_m=0.3, contour_m=0.15, obstacle_m=0.2)


def placed_with_polygons(domain: Domain, centers: FloatArray) -> list[float]:
    """Distance of each circle from z_c when Algorithm 1 is done with shapely, given the circles before it."""
    gaps, target = domain.gaps, Point(domain.center)
    distances = []
    for index, radius in enumerate(domain.radii):
        free = Polygon(domain.contour).buffer(-(radius + gaps.contour_m), quad_segs=64)
        for other, size in zip(centers[:index], domain.radii[:index], strict=True):
            free = free.difference(Point(other).buffer(radius + size + gaps.robot_m, quad_segs=256))
        distances.append(nearest_points(free, target)[0].distance(target))
    return distances


@pytest.mark.parametrize("name", ["formation_1", "formation_2"])
def test_each_circle_is_as_near_to_the_center_as_subtracting_polygons_finds(name: str) -> None:
    domain = Domain(load_shape(name), (), np.tile([0.15, 0.3, 0.5], 8), GAPS)

    centers = place(domain)

    assert centers is not None
    distances = np.linalg.norm(centers - domain.center, axis=1)
    # Both go about arcs with chords, and the region keeps a margin of 1 % for that: a few millimetres.
    np.testing.assert_allclose(distances, placed_with_polygons(domain, centers), atol=0.01)


def test_the_first_circle_stands_on_a_center_that_is_free() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])

    centers = place(Domain(square, (), np.array([0.5]), GAPS))

    assert centers is not None
    assert centers.tolist() == [[2.0, 2.0]]


def test_circles_that_do_not_fit_are_told() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])

    assert place(Domain(square, (), np.full(20, 0.5), GAPS)) is None
    assert place(Domain(square, (), np.array([2.0]), GAPS)) is None


def test_another_first_circle_makes_another_cluster() -> None:
    domain = Domain(load_shape("formation_3"), (), np.tile([0.15, 0.3, 0.5], 8), GAPS)

    usual, other = place(domain), place(domain, 5)

    assert usual is not None
    assert other is not None
    np.testing.assert_allclose(usual[0], domain.center)
    np.testing.assert_allclose(other[5], domain.center)
    apart = np.linalg.norm(other[:, None] - other, axis=2) - domain.least_distances
    assert apart.min() >= -1e-6


def test_the_shortage_is_where_placing_ends() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    domain = Domain(square, (), np.array([0.5, 0.5, 1.5, 0.5]), GAPS)

    short = shortage(domain)

    assert short is not None
    assert (short.circle, short.placed) == (2, 2)
    assert short.free_area == pytest.approx(16.0 - 2.0 * np.pi * 0.25)
    assert shortage(domain.scaled(3.0)) is None
