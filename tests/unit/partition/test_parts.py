import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose

from mission_computer.shape import Placement, placed_shape
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.bridges import bridged, one_contour
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.partition import Method, PartitionConfig, partition
from swarm_msgs_py.partition.parts import parts_of, shared_out
from swarm_msgs_py.roster import Roster, TypeGroup

BOX = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]])
TWO = bridged([BOX, BOX * (2.0, 1.0) + (10.0, 0.0)])
ROSTER = Roster(
    groups=(TypeGroup(type=1, count=6, coverage_radius_m=0.15), TypeGroup(type=3, count=6, coverage_radius_m=0.5))
)


def test_bridges_join_parts_and_slits_do_not_make_any() -> None:
    ring = one_contour(shapely.Polygon(BOX).difference(shapely.Point(3.0, 3.0).buffer(1.0)))

    first, second = parts_of(TWO)

    assert_allclose([signed_area(first), signed_area(second)], [36.0, 72.0], rtol=1e-3)
    assert len(parts_of(ring)) == 1
    assert parts_of(BOX)[0] is BOX


@pytest.mark.parametrize("method", Method)
def test_each_part_gets_robots_by_its_area(method: Method) -> None:
    goals = partition(TWO, ROSTER, config=PartitionConfig(method=method))

    in_first = goals.positions[:, 0] < 8.0
    assert in_first.sum() == 4  # of 12, a third
    assert sorted(goals.types[in_first]) == [1, 1, 3, 3]
    assert sorted(goals.types) == sorted(ROSTER.interleaved_types())


def test_what_has_no_room_in_a_small_part_goes_to_another() -> None:
    dot = bridged([BOX, np.array([[8.0, 0.0], [8.8, 0.0], [8.8, 0.8], [8.0, 0.8]])])

    goals = partition(dot, Roster(groups=(TypeGroup(type=3, count=8, coverage_radius_m=0.5),)))

    assert (goals.positions[:, 0] < 6.0).all()
    assert len(goals.types) == 8


def test_shares_are_limited_by_room() -> None:
    types, parts = np.ones(9, dtype=np.int64), (BOX, BOX + 10.0)

    shares = shared_out(parts, types, np.array([2, 9]))

    assert shares is not None
    assert [len(share) for share in shares] == [2, 7]
    assert shared_out(parts, types, np.array([2, 6])) is None


def test_goals_of_a_text_stand_in_all_of_its_letters() -> None:
    contour = placed_shape("text:LAB", Placement(area=200.0))

    goals = partition(contour, ROSTER)

    for letter in parts_of(contour):
        assert shapely.contains_xy(shapely.Polygon(letter), *goals.positions.T).sum() >= 2


def test_a_hole_at_the_edge_is_refused() -> None:
    near = shapely.Polygon(BOX, [[(1.0, 0.01), (2.0, 0.01), (2.0, 1.0)]])

    with pytest.raises(ShapeError, match=r"less than 0\.02 m from the edge"):
        one_contour(near)
