"""Inertial sensor, position sensor and ranging: means, noise, bias, independence."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import FixConfig, ImuConfig, RangingConfig, RangingModel
from swarm_sim.radio.links import LinkTable
from swarm_sim.sensors.fix import PositionSensor
from swarm_sim.sensors.imu import Imu
from swarm_sim.sensors.ranging import Ranging
from swarm_sim.world.world import BodyState

TICKS = 2000


def bodies(yaws: list[float]) -> BodyState:
    n = len(yaws)
    return BodyState(np.zeros((n, 2)), np.zeros(n), np.array(yaws), np.zeros((n, 2)), np.arange(n) / 10.0)


def test_acceleration_is_reported_in_the_body_frame() -> None:
    imu = Imu(ImuConfig(bias_max_mps2=0.0, sigma_mps2=0.0), 2, seed=1)

    samples = imu.measure(0, bodies([0.0, np.pi / 2.0]), np.array([[1.0, 0.5], [1.0, 0.5]]))

    assert_allclose(samples[0].acceleration_body, [1.0, 0.5])
    assert_allclose(samples[1].acceleration_body, [0.5, -1.0], atol=1e-15)
    assert (samples[1].yaw, samples[1].yaw_rate) == (np.pi / 2.0, 0.1)


def test_acceleration_noise_is_white_around_a_constant_bias_per_robot() -> None:
    imu = Imu(ImuConfig(), 4, seed=1)
    still = np.zeros((4, 2))

    record = np.array([[s.acceleration_body for s in imu.measure(k, bodies([0.0] * 4), still)] for k in range(TICKS)])

    assert np.abs(imu.bias).max() <= 9.81e-4
    assert len(np.unique(imu.bias)) == 8
    assert_allclose(record.mean(axis=0), imu.bias, atol=4.0 * 0.01 / np.sqrt(TICKS))
    assert_allclose(record.std(axis=0), 0.01, rtol=0.08)
    assert np.abs((record[1:] * record[:-1]).mean()) < 1e-5


def test_heading_is_exact_by_default_and_noisy_on_request() -> None:
    exact = Imu(ImuConfig(), 1, seed=1).measure(0, bodies([0.3]), np.zeros((1, 2)))
    noisy = Imu(ImuConfig(yaw_sigma_rad=0.1), 1, seed=1).measure(0, bodies([0.3]), np.zeros((1, 2)))

    assert exact[0].yaw == 0.3
    assert 0.0 < abs(noisy[0].yaw - 0.3) < 0.5


def test_a_fix_has_the_stated_noise_and_goes_only_to_those_that_carry_a_sensor() -> None:
    sensor = PositionSensor(FixConfig(sigma_m=0.02), np.array([True, False, True]), seed=1)
    truth = np.array([(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)])

    record = [sensor.measure(k, truth) for k in range(TICKS)]

    assert all(fixes[1] is None for fixes in record)
    errors = np.array([fixes[2].position - truth[2] for fixes in record if fixes[2]])
    assert errors.shape == (TICKS, 2)
    assert record[0][0] is not None
    assert record[0][0].sigma == 0.02
    assert_allclose(errors.std(axis=0), 0.02, rtol=0.08)
    assert_allclose(errors.mean(axis=0), 0.0, atol=4.0 * 0.02 / np.sqrt(TICKS))


def test_giving_one_robot_a_sensor_changes_nothing_for_another() -> None:
    truth = np.zeros((2, 2))
    one = PositionSensor(FixConfig(), np.array([False, True]), seed=1).measure(7, truth)[1]
    both = PositionSensor(FixConfig(), np.array([True, True]), seed=1).measure(7, truth)[1]

    assert one is not None
    assert both is not None
    assert_array_equal(one.position, both.position)


def links(connected: list[list[int]], distances: list[list[float]]) -> LinkTable:
    return LinkTable(np.array(connected, dtype=np.bool_), np.array(distances))


TRIANGLE = links([[0, 1, 0], [1, 0, 1], [0, 1, 0]], [[0, 10, 30], [10, 0, 20], [30, 20, 0]])
CORNERS = np.array([(0.0, 0.0), (10.0, 0.0), (30.0, 0.0)])


def full_links(positions: FloatArray) -> LinkTable:
    x, y = positions.T
    return LinkTable(~np.eye(len(x), dtype=np.bool_), np.hypot(x - x[:, None], y - y[:, None]))


def position_ranging(robots: int) -> Ranging:
    return Ranging(RangingConfig(model=RangingModel.POSITION, sigma_m=2.0, period_s=0.0), np.arange(robots), 0.5, 1)


def ranged_from(scans: list[RangeScan], positions: FloatArray) -> FloatArray:
    """Return where every robot's ranges meet (n, 2), by differences of circle equations."""
    points = []
    for scan in scans:
        circles = positions[scan.neighbors]
        lines = 2.0 * (circles[1:] - circles[0])
        offsets = (circles[1:] ** 2 - circles[0] ** 2).sum(axis=1) - scan.ranges[1:] ** 2 + scan.ranges[0] ** 2
        points.append(np.linalg.lstsq(lines, offsets)[0])
        assert_allclose(np.hypot(*(circles - points[-1]).T), scan.ranges)
    return np.array(points)


def test_ranges_exist_between_direct_neighbors_only() -> None:
    scans = Ranging(RangingConfig(sigma_m=0.0), np.array([3, 5, 9]), 0.5, seed=1).measure(0, CORNERS, TRIANGLE)

    assert [scan.neighbors.tolist() for scan in scans] == [[5], [3, 9], [5]]
    assert [scan.ranges.tolist() for scan in scans] == [[10.0], [10.0, 20.0], [20.0]]


def test_the_antenna_of_the_mission_computer_does_not_range() -> None:
    with_antenna = links([[0, 1, 1], [1, 0, 1], [1, 1, 0]], [[0, 10, 5], [10, 0, 5], [5, 5, 0]])

    scans = Ranging(RangingConfig(sigma_m=0.0), np.array([0, 1]), 0.5, seed=1).measure(0, CORNERS[:2], with_antenna)

    assert [scan.neighbors.tolist() for scan in scans] == [[1], [0]]


def test_range_noise_is_white_independent_both_ways_and_never_makes_a_range_negative() -> None:
    ranging = Ranging(RangingConfig(sigma_m=2.0, period_s=0.0), np.array([0, 1, 2]), 0.5, seed=1)
    near = links([[0, 1, 0], [1, 0, 0], [0, 0, 0]], [[0, 0.5, 9], [0.5, 0, 9], [9, 9, 0]])

    record = np.array([[scan.ranges[0] for scan in ranging.measure(k, CORNERS, TRIANGLE)] for k in range(TICKS)])
    close = np.array([ranging.measure(k, CORNERS, near)[0].ranges[0] for k in range(200)])

    assert_allclose(record.std(axis=0), 2.0, rtol=0.08)
    assert_allclose(record.mean(axis=0), [10.0, 10.0, 20.0], atol=0.2)
    assert abs(np.corrcoef(record.T)[0, 1]) < 0.1
    assert close.min() == 0.0


def test_in_the_model_of_the_thesis_one_displaced_point_explains_all_ranges_of_a_robot() -> None:
    ranging = position_ranging(4)
    positions = np.array([(0.0, 0.0), (10.0, 0.0), (-4.0, 9.0), (3.0, -8.0)])
    record = np.array(
        [ranged_from(ranging.measure(k, positions, full_links(positions)), positions) for k in range(500)]
    )

    errors = record - positions

    assert_allclose(errors.mean(axis=0), 0.0, atol=4.0 * 2.0 / np.sqrt(500))
    assert_allclose(errors.std(axis=0), 2.0, rtol=0.12)
    flat = errors.reshape(500, -1)
    assert np.abs(np.corrcoef(flat.T) - np.eye(8)).max() < 0.2  # between axes and robots
    assert np.abs(np.corrcoef(flat[1:, 0], flat[:-1, 0])[0, 1]) < 0.2  # between rounds


def test_in_the_model_of_the_thesis_the_geometry_of_the_neighbors_has_no_effect() -> None:
    wide = np.array([(0.0, 0.0), (10.0, 0.0), (-4.0, 9.0), (3.0, -8.0)])
    narrow = np.array([(0.0, 0.0), (10.0, 1.0), (10.0, 0.0), (11.0, -1.0)])

    one, other = (ranged_from(position_ranging(4).measure(0, p, full_links(p)), p)[0] for p in (wide, narrow))

    assert_allclose(one, other, atol=1e-9)
    assert np.hypot(*one) > 0.1


@pytest.mark.parametrize("model", RangingModel)
def test_a_death_or_a_lost_link_shifts_no_range_of_anybody_else(model: RangingModel) -> None:
    positions = np.array([(0.0, 0.0), (10.0, 0.0), (-4.0, 9.0), (3.0, -8.0)])
    whole, without_1 = full_links(positions), full_links(positions)
    without_1.connected[1, :] = without_1.connected[:, 1] = False
    ranging = Ranging(RangingConfig(model=model), np.arange(4), 0.5, seed=1)

    before, after = ranging.measure(0, positions, whole), ranging.measure(0, positions, without_1)

    assert [scan.neighbors.tolist() for scan in after] == [[2, 3], [], [0, 3], [0, 2]]
    for robot in (0, 2, 3):
        assert_array_equal(after[robot].ranges, before[robot].ranges[before[robot].neighbors != 1])


def test_without_noise_both_models_measure_the_distances() -> None:
    positions = np.array([(0.0, 0.0), (10.0, 0.0), (-4.0, 9.0), (3.0, -8.0)])

    scans = [
        Ranging(RangingConfig(model=model, sigma_m=0.0), np.arange(4), 0.5, seed=1).measure(
            0, positions, full_links(positions)
        )
        for model in RangingModel
    ]

    for one, other in zip(*scans, strict=True):
        assert_allclose(one.ranges, other.ranges, rtol=1e-15)
    assert_allclose(scans[1][0].ranges, np.hypot(*positions[1:].T))


@pytest.mark.parametrize(
    ("period_s", "due"),
    [(3.0, [0, 6, 12]), (1.0, [0, 2, 4, 6, 8, 10, 12]), (0.5, list(range(13))), (0.0, list(range(13)))],
)
def test_robots_range_once_per_period_and_have_empty_scans_between(period_s: float, due: list[int]) -> None:
    ranging = Ranging(RangingConfig(period_s=period_s), np.array([0, 1, 2]), 0.5, seed=1)

    scans = [ranging.measure(tick, CORNERS, TRIANGLE) for tick in range(13)]

    assert [tick for tick in range(13) if scans[tick][1].neighbors.tolist() == [0, 2]] == due
    assert all(not len(s.neighbors) and not len(s.ranges) for k in set(range(13)) - set(due) for s in scans[k])
    assert all(s.neighbors.dtype == np.int64 and s.ranges.dtype == np.float64 for scan in scans for s in scan)


@pytest.mark.parametrize("seed", [1, 2])
def test_readings_depend_on_seed_and_tick_only(seed: int) -> None:
    first, second = (PositionSensor(FixConfig(), np.array([True]), seed) for _ in range(2))
    first.measure(0, np.zeros((1, 2)))  # asked once more than the other

    again, once = first.measure(1, np.zeros((1, 2)))[0], second.measure(1, np.zeros((1, 2)))[0]

    assert again is not None
    assert once is not None
    assert_array_equal(again.position, once.position)
