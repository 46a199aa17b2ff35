import numpy as np
import pytest
from packed_shapes import FORMATIONS, field_domain, random_points

from swarm_msgs_py.partition.spreading import spread_sizes


@pytest.mark.parametrize("name", FORMATIONS)
def test_every_part_of_a_shape_gets_its_share_of_each_size(name: str) -> None:
    domain, centers = field_domain(name), random_points(name, 1)

    spread = spread_sizes(domain, centers)

    for radius in domain.classes:
        own = domain.radii == radius
        for angle in np.linspace(0.0, np.pi, 6, endpoint=False):
            # The half of the centers on one side of a line through the middle.
            along = spread @ [np.cos(angle), np.sin(angle)]
            assert 0.3 <= (along[own] > np.median(along)).mean() <= 0.7


def test_centers_change_hands_and_nothing_else() -> None:
    domain, centers = field_domain("formation_1"), random_points("formation_1", 2)

    spread = spread_sizes(domain, centers)

    assert sorted(map(tuple, spread)) == sorted(map(tuple, centers))
    np.testing.assert_array_equal(spread_sizes(domain, centers[::-1]), spread)
