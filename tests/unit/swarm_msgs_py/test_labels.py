from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_msgs_py.messages.radio import HOPS_INFINITE, RouteRows
from swarm_msgs_py.networking.labels import advert_of, broken, hops_of, is_finite, labels_of, sequences_of, unpacked
from swarm_msgs_py.types import MISSION, NodeId


def make_label(sequence: int, hops: int) -> np.ndarray:
    return labels_of(np.array([sequence]), np.array([hops]))


@pytest.mark.parametrize("sequence", [0, 1, 32767, 32768, 65535])
@pytest.mark.parametrize("hops", [0, 1, 254, HOPS_INFINITE])
def test_label_keeps_number_and_hops(sequence: int, hops: int) -> None:
    label = make_label(sequence, hops)

    assert (sequences_of(label)[0], hops_of(label)[0]) == (sequence, hops)
    assert is_finite(label)[0] == (hops != HOPS_INFINITE)


@pytest.mark.parametrize(
    ("better", "worse"),
    [((102, 9), (100, 1)), ((100, 1), (100, 2)), ((101, 255), (100, 1)), ((0, 9), (65534, 1)), ((32766, 9), (0, 1))],
    ids=["newer", "shorter", "newer though broken", "wrapped", "almost half the circle"],
)
def test_difference_of_labels_tells_the_better_one(better: tuple[int, int], worse: tuple[int, int]) -> None:
    assert (make_label(*better) - make_label(*worse))[0] > 0
    assert (make_label(*worse) - make_label(*better))[0] < 0


@pytest.mark.parametrize(
    ("before", "after"), [((100, 3), 101), ((65534, 3), 65535), ((101, 255), 101), ((100, 255), 101)]
)
def test_break_takes_the_next_odd_number(before: tuple[int, int], after: int) -> None:
    label = broken(make_label(*before))

    assert (sequences_of(label)[0], hops_of(label)[0]) == (after, HOPS_INFINITE)


def test_adverts_of_several_neighbors_are_unpacked_as_columns_with_one_hop_more() -> None:
    first = advert_of(NodeId(3), RouteRows(np.array([3, 40000]), np.array([0, 255]), np.array([100, 65535])))
    second = advert_of(MISSION, RouteRows(np.array([7]), np.array([253]), np.array([40000])))

    sources, destinations, labels = unpacked([first, second])

    assert_array_equal(sources, [3, 3, MISSION])
    assert_array_equal(destinations, [3, 40000, 7])
    assert_array_equal(hops_of(labels), [1, 255, 254])
    assert_array_equal(sequences_of(labels), [100, 65535, 40000])
