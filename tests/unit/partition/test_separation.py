import numpy as np
import pytest
from numpy.testing import assert_allclose

from swarm_msgs_py.partition.config import Gaps
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.separation import Separator
from swarm_msgs_py.types import FloatArray

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])


@pytest.fixture
def domain() -> Domain:
    return Domain(SQUARE, (), np.array([0.5, 0.5, 1.0]), Gaps(robot_m=0.2, contour_m=0.1, obstacle_m=0.1))


def distances(centers: FloatArray) -> FloatArray:
    return np.linalg.norm(centers[[0, 0, 1]] - centers[[1, 2, 2]], axis=1)


def test_circles_with_room_stay_where_they_are(domain: Domain) -> None:
    centers = np.array([[2.0, 2.0], [5.0, 5.0], [8.0, 8.0]])

    assert_allclose(Separator(domain).apart(centers, 5), centers)


def test_overlapping_circles_part_by_equal_shares(domain: Domain) -> None:
    moved = Separator(domain).apart(np.array([[4.0, 5.0], [4.6, 5.0], [8.0, 8.0]]), 5)

    assert_allclose(moved, [[3.7, 5.0], [4.9, 5.0], [8.0, 8.0]], atol=1e-3)


def test_circles_in_one_place_part_too(domain: Domain) -> None:
    separator = Separator(domain)

    moved = separator.apart(np.full((3, 2), 5.0), 500)

    assert separator.is_separated(moved)
    assert (distances(moved) >= np.array([1.2, 1.7, 1.7]) - 1e-6).all()


def test_circles_outside_come_in(domain: Domain) -> None:
    moved = Separator(domain).apart(np.array([[-3.0, 5.0], [5.0, 12.0], [20.0, 20.0]]), 5)

    assert_allclose(moved, [[0.6, 5.0], [5.0, 9.4], [8.9, 8.9]], atol=0.015)


def test_what_it_remembers_does_not_change_its_results(domain: Domain) -> None:
    generator = np.random.default_rng(3)
    used, centers = Separator(domain), np.array([[2.0, 2.0], [5.0, 5.0], [8.0, 8.0]])

    for _ in range(300):
        centers = centers + generator.normal(0.0, 0.4, (3, 2))
        moved = used.apart(centers, 3)
        np.testing.assert_array_equal(moved, Separator(domain).apart(centers, 3))
        centers = moved
