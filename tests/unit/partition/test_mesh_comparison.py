import numpy as np
import pytest
import shapely
from packed_shapes import centers_of, field_domain, random_points

from swarm_msgs_py.partition import Method
from swarm_msgs_py.partition.mesh_comparison import MeshComparison

NAME = "formation_1"
DOMAIN = field_domain(NAME)
SHAPE = shapely.Polygon(DOMAIN.contour)
PACKED = centers_of(Method.BUBBLE_PACKING, NAME)


def test_a_mesh_is_as_good_as_itself_but_for_the_margin_of_rounding() -> None:
    standing = MeshComparison(SHAPE, DOMAIN.radii, PACKED).standing(PACKED)

    assert standing.excess == pytest.approx(5 * 0.005)
    assert standing.total == pytest.approx(7.0)
    assert not standing.is_worse_connected


def test_random_points_are_worse_than_a_packing_and_the_packing_is_better_than_they() -> None:
    drawn = random_points(NAME, 3)

    worse = MeshComparison(SHAPE, DOMAIN.radii, PACKED).standing(drawn)
    better = MeshComparison(SHAPE, DOMAIN.radii, drawn).standing(PACKED)

    assert worse.excess > 1.0
    assert worse.is_worse_connected
    assert better.excess == 0.0
    assert not better.is_worse_connected
    assert better < worse


def test_what_is_not_worse_in_any_metric_comes_before_what_is_better_on_the_whole() -> None:
    comparison = MeshComparison(SHAPE, DOMAIN.radii, random_points(NAME, 3))

    assert comparison.standing(PACKED) < comparison.standing(random_points(NAME, 4))


def test_meshes_of_too_few_robots_for_a_metric_are_compared_by_the_others() -> None:
    square = shapely.box(-2.0, -2.0, 2.0, 2.0)
    comparison = MeshComparison(square, np.array([0.3]), np.array([[0.5, 0.0]]))

    middle, corner = (comparison.standing(np.array([[place, place]])) for place in (0.0, 1.0))
    assert middle.excess == pytest.approx(0.005)  # its cell is the same square as the reference's
    assert corner.excess > middle.excess
