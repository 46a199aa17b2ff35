"""Ticks that a robot misses, samples that cannot be true, and restarts: what it still knows afterwards."""

from __future__ import annotations

import math

import numpy as np
import pytest
from builders import make_agent, make_agent_inputs
from numpy.testing import assert_allclose

from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.hypotheses import merged
from swarm_agent.localization.localizer import Localizer
from swarm_agent.localization.motion_model import BIAS, STATES, belief_at, restarted
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan

DT = 0.5
STILL = ImuSample(np.zeros(2), 0.0, 0.0)
NO_RANGES = RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0))
EAST = np.array([0.5, 0.0])
NAN = math.nan
BROKEN = [
    ImuSample(np.array([NAN, 0.0]), 0.0, 0.0),
    ImuSample(np.array([0.0, math.inf]), 0.0, 0.0),
    ImuSample(np.array([1e200, 0.0]), 0.0, 0.0),
    ImuSample(np.zeros(2), NAN, 0.0),
    ImuSample(np.zeros(2), 1e200, 0.0),
]


class Driver:
    """A robot that starts in the origin and drives east at half a meter per second from tick 1 on."""

    def __init__(self, config: LpsConfig | None = None) -> None:
        self.localizer = Localizer(config or LpsConfig(), DT, PositionFix(np.zeros(2), 0.05))
        self.step(0, told=np.zeros(2))
        self.step(1, ImuSample(EAST / DT, 0.0, 0.0))

    def step(
        self, tick: int, imu: ImuSample = STILL, fix: PositionFix | None = None, told: np.ndarray | None = EAST
    ) -> Estimate:
        estimate = self.localizer.step(tick, imu, fix, NO_RANGES, {}, told=told)
        assert estimate is not None
        return estimate

    def drive(self, first: int, last: int) -> Estimate:
        return [self.step(tick) for tick in range(first, last + 1)][-1]


def sigma_x(estimate: Estimate) -> float:
    return math.sqrt(estimate.covariance[0, 0])


def test_missed_ticks_are_driven_on_through_and_what_may_have_happened_is_admitted() -> None:
    driver = Driver()
    before = driver.drive(2, 8)

    after = driver.step(29)  # ticks 9 to 28 are missing

    assert_allclose(after.position - before.position, [21 * DT * 0.5, 0.0], atol=0.05)
    assert_allclose(after.velocity, EAST, atol=0.05)
    gap = 20 * DT
    assert sigma_x(after) == pytest.approx(gap * LpsConfig().restart_speed_sigma_mps, rel=0.2)


def test_who_stood_still_in_the_gap_is_within_its_claim() -> None:
    driver = Driver()
    before = driver.drive(2, 8)

    after = driver.step(29, told=np.zeros(2))

    assert np.hypot(*(after.position - before.position)) < 3.0 * sigma_x(after)


def test_a_command_from_before_a_gap_says_nothing_of_the_motion_after_it() -> None:
    driver = Driver()
    driver.drive(2, 8)

    speeds = [math.sqrt(merged(driver.localizer._hypotheses).gaussian.covariance[1, 1])]
    for tick in (29, 30, 31):
        driver.step(tick)
        speeds.append(math.sqrt(merged(driver.localizer._hypotheses).gaussian.covariance[1, 1]))

    assert speeds[0] < 0.03
    assert speeds[1] == pytest.approx(LpsConfig().restart_speed_sigma_mps, rel=0.05)
    assert speeds[2] == pytest.approx(speeds[1], rel=0.05)
    assert speeds[3] < 0.03


def test_ticks_that_follow_each_other_leave_no_gap() -> None:
    one, other = Driver(), Driver()

    assert one.drive(2, 20).covariance.tobytes() == other.drive(2, 20).covariance.tobytes()
    assert sigma_x(one.drive(21, 40)) < 0.3


@pytest.mark.parametrize("imu", BROKEN, ids=["nan", "inf", "huge", "yaw nan", "yaw huge"])
def test_a_sample_that_cannot_be_true_counts_as_a_missed_tick(imu: ImuSample) -> None:
    broken, missed = Driver(), Driver()
    for driver in (broken, missed):
        driver.drive(2, 8)

    during = broken.step(9, imu)
    after, expected = broken.step(10), missed.step(10)

    assert np.isfinite(during.covariance).all()
    assert during.yaw == 0.0
    assert_allclose(during.position, [0.5 * (DT - LpsConfig().push_delay_s) + 8 * 0.5 * DT, 0.0], atol=0.1)
    assert_allclose(after.position, expected.position, atol=0.05)
    assert sigma_x(after) >= sigma_x(expected) > 0.2


def test_the_heading_stays_what_it_was_when_last_it_made_sense() -> None:
    driver = Driver()
    driver.step(2, ImuSample(np.zeros(2), 0.7, 0.0))

    assert driver.step(3, BROKEN[3]).yaw == 0.7
    assert driver.localizer.heading(BROKEN[4]) == 0.7
    assert driver.localizer.heading(ImuSample(np.zeros(2), 0.8, 0.0)) == 0.8


@pytest.mark.parametrize("imu", BROKEN, ids=["nan", "inf", "huge", "yaw nan", "yaw huge"])
def test_an_agent_survives_a_broken_sample(imu: ImuSample) -> None:
    agent = make_agent()
    for tick in range(12):
        outputs = agent.step(make_agent_inputs(tick, imu=imu if tick == 8 else STILL, proximity=np.array([[2.0, 0.0]])))
        command = outputs.command
        assert np.isfinite([command.forward, command.left, command.yaw_rate, outputs.report.yaw]).all()

    assert_allclose(outputs.report.position, [0.0, 0.0], atol=0.05)


def test_a_restart_at_a_fix_forgets_the_place_and_keeps_velocity_and_bias() -> None:
    driver = Driver(LpsConfig(mode=LpsMode.FIXES, rejections_max=2))
    before = driver.drive(2, 8)
    state = merged(driver.localizer._hypotheses).gaussian
    elsewhere = PositionFix(np.array([30.0, 0.0]), 1.0)

    driver.step(9, fix=elsewhere)
    after = driver.step(10, fix=elsewhere)

    assert_allclose(after.position, [30.0, 0.0], atol=1e-9)
    assert_allclose(after.covariance, np.eye(2))
    assert_allclose(after.velocity, before.velocity, atol=0.01)
    gaussian = merged(driver.localizer._hypotheses).gaussian
    assert_allclose(gaussian.mean[BIAS], state.mean[BIAS], atol=1e-6)
    assert math.sqrt(gaussian.covariance[1, 1]) == pytest.approx(LpsConfig().restart_speed_sigma_mps, rel=0.01)


def test_a_restarted_belief_is_still_one() -> None:
    start = belief_at(np.zeros(2), np.eye(2), 0.1, 1e-3)
    mixing = np.eye(STATES) + 0.3 * np.triu(np.ones((STATES, STATES)), 1)
    mixed = type(start)(start.mean + 1.0, mixing @ start.covariance @ mixing.T)

    after = restarted(mixed, 0.5, np.array([5.0, 6.0]), 4.0 * np.eye(2))

    assert np.linalg.eigvalsh(after.covariance).min() > 0.0
    assert after.mean.tolist() == [5.0, 1.0, 6.0, 1.0, 1.0, 1.0]
