"""What a robot makes of a round of ranging and of the hellos that it heard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from builders import make_presence
from numpy.testing import assert_allclose, assert_array_equal

from swarm_agent.localization.observations import VAGUE_M, RangeObservations, observe, strangers
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.types import NodeId

DT = 0.5
AGE_MAX = 8  # ticks
TICK = 100


def scan_of(*pairs: tuple[int, float]) -> RangeScan:
    return RangeScan(np.array([n for n, _ in pairs], dtype=np.int64), np.array([r for _, r in pairs], dtype=float))


def heard(**neighbors: Presence) -> dict[NodeId, Presence]:
    return {NodeId(int(name[1:])): presence for name, presence in neighbors.items()}


def seen_at(
    tick: int, scan: RangeScan, neighbors: Mapping[NodeId, Presence]
) -> tuple[RangeObservations, RangeObservations]:
    return observe(scan, neighbors, tick, DT, AGE_MAX)


def counts(pair: Sequence[RangeObservations]) -> tuple[int, int]:
    return len(pair[0]), len(pair[1])


def test_beacons_are_told_by_their_hellos() -> None:
    neighbors = heard(
        n2=make_presence(1.0, 2.0, tick=TICK),
        n5=make_presence(3.0, 4.0, tick=TICK, is_beacon=False, shared=0.25),
        n9=make_presence(5.0, 6.0, tick=TICK),
    )

    beacons, others = seen_at(TICK, scan_of((2, 7.0), (5, 8.0), (9, 9.0)), neighbors)

    assert_array_equal(beacons.positions, [[1.0, 2.0], [5.0, 6.0]])
    assert_array_equal(beacons.ranges, [7.0, 9.0])
    assert_array_equal(others.positions, [[3.0, 4.0]])
    assert_array_equal(others.ranges, [8.0])
    assert_array_equal(others.shared, [0.25])


def test_columns_of_the_covariance_stay_in_their_order() -> None:
    presence = make_presence(tick=TICK, covariance=np.array([[4.0, -1.0], [-1.0, 9.0]]))

    beacons, _ = seen_at(TICK, scan_of((2, 7.0)), heard(n2=presence))

    assert_array_equal(beacons.covariances, [[4.0, -1.0, 9.0]])


@pytest.mark.parametrize("age", range(AGE_MAX + 1))
def test_an_old_word_is_moved_on_with_its_velocity(age: int) -> None:
    presence = make_presence(1.0, 2.0, tick=TICK - age, velocity=np.array([0.4, -0.2]))

    beacons, _ = seen_at(TICK, scan_of((2, 7.0)), heard(n2=presence))

    assert_allclose(beacons.positions, [[1.0 + 0.4 * DT * age, 2.0 - 0.2 * DT * age]])


@pytest.mark.parametrize("tick", [65536, 65536 + AGE_MAX - 1, 5 * 65536 + 2])
def test_ages_are_counted_across_the_wrap_of_sixteen_bits(tick: int) -> None:
    presence = make_presence(tick=(tick - AGE_MAX) % 65536, velocity=np.array([1.0, 0.0]))

    beacons, _ = seen_at(tick, scan_of((2, 7.0)), heard(n2=presence))

    assert_allclose(beacons.positions, [[AGE_MAX * DT, 0.0]])


@pytest.mark.parametrize("offset", [-AGE_MAX - 1, -1000, -32768, 1, 30000], ids="{:+d} ticks".format)
def test_a_word_too_old_or_from_another_clock_is_not_believed(offset: int) -> None:
    presence = make_presence(tick=(TICK + offset) % 65536)

    assert counts(seen_at(TICK, scan_of((2, 7.0)), heard(n2=presence))) == (0, 0)


@pytest.mark.parametrize("is_beacon", [True, False])
@pytest.mark.parametrize(
    "covariance",
    [np.eye(2) * SIGMA_UNKNOWN**2, np.diag([0.1, SIGMA_UNKNOWN**2]), np.diag([SIGMA_UNKNOWN**2, 0.1])],
    ids=["nothing", "x only", "y only"],
)
def test_who_does_not_know_where_it_is_is_no_landmark(is_beacon: bool, covariance: np.ndarray) -> None:
    presence = make_presence(tick=TICK, covariance=covariance, is_beacon=is_beacon)

    assert counts(seen_at(TICK, scan_of((2, 7.0)), heard(n2=presence))) == (0, 0)


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
def test_a_range_that_is_no_number_is_left_out_and_the_others_stay(broken: float) -> None:
    neighbors = heard(n2=make_presence(tick=TICK), n3=make_presence(1.0, tick=TICK))

    beacons, _ = seen_at(TICK, scan_of((2, broken), (3, 4.0)), neighbors)

    assert_array_equal(beacons.ranges, [4.0])
    assert_array_equal(beacons.positions, [[1.0, 0.0]])


def test_a_range_to_a_stranger_is_left_out() -> None:
    assert counts(seen_at(TICK, scan_of((2, 7.0), (3, 1.0)), heard(n3=make_presence(tick=TICK)))) == (1, 0)


def test_without_ranges_or_neighbors_there_is_nothing_to_see() -> None:
    assert counts(seen_at(TICK, scan_of(), heard(n2=make_presence(tick=TICK)))) == (0, 0)
    assert counts(seen_at(TICK, scan_of((2, 7.0)), {})) == (0, 0)


def test_a_mask_picks_whole_observations() -> None:
    neighbors = {NodeId(n): make_presence(float(n), tick=TICK, sigma=float(n), shared=n / 10) for n in range(1, 4)}
    beacons, _ = seen_at(TICK, scan_of((1, 1.0), (2, 2.0), (3, 3.0)), neighbors)

    picked = beacons.only(np.array([True, False, True]))

    assert_array_equal(picked.ranges, [1.0, 3.0])
    assert_array_equal(picked.positions[:, 0], [1.0, 3.0])
    assert_allclose(picked.covariances[:, 0], [1.0, 9.0])
    assert_array_equal(picked.shared, [0.1, 0.3])


def test_strangers_are_robots_that_hardly_know_where_they_are_and_gave_a_range() -> None:
    lost = make_presence(sigma=SIGMA_UNKNOWN)
    neighbors = {
        NodeId(1): make_presence(sigma=0.9 * VAGUE_M),
        NodeId(2): make_presence(sigma=1.1 * VAGUE_M),
        NodeId(3): lost,
        NodeId(4): lost,
        NodeId(5): replace(lost, robot_type=0),
        NodeId(6): lost,
    }

    assert strangers(scan_of((1, 1.0), (2, 2.0), (3, 3.0), (4, np.nan), (5, 5.0), (9, 9.0)), neighbors).tolist() == [
        2,
        3,
    ]
