"""The modes of the local positioning system, on scripted geometries with exact and broken ranges."""

from __future__ import annotations

import math

import numpy as np
import pytest
from builders import make_presence
from numpy.testing import assert_allclose

from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.localizer import BEACON_MEMORY_S, Localizer
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.types import FloatArray, NodeId

DT = 0.5
STILL = ImuSample(np.zeros(2), 0.0, 0.0)
NO_RANGES = RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0))
TRUTH = np.array([3.0, 1.0])
TRIANGLE = ((10.0, 0.0), (-8.0, 9.0), (-7.0, -9.0))
LINE = ((-10.0, -4.0), (0.0, -4.0), (10.0, -4.0))
BY_RANGES = (LpsMode.RANGE_EKF, LpsMode.COOPERATIVE)
BY_FIXES = (LpsMode.LITERAL, LpsMode.FIXES)


class Field:
    """One robot at rest, and neighbors at given places."""

    def __init__(self, mode: LpsMode, start: PositionFix | None = None, **settings: float) -> None:
        self.localizer = Localizer(LpsConfig(mode=mode, **settings), DT, start)  # type: ignore[arg-type]
        self.tick = -1

    def step(
        self,
        beacons: tuple[tuple[float, float], ...] = (),
        others: tuple[tuple[float, float], ...] = (),
        *,
        at: FloatArray = TRUTH,
        fix: PositionFix | None = None,
        sigma: float = 0.5,
        stretch: float = 0.0,
    ) -> Estimate | None:
        """Range from `at` to everybody; `stretch` is added to the ranges to beacons [m]."""
        self.tick += 1
        places = np.array([*beacons, *others]).reshape(-1, 2)
        neighbors: dict[NodeId, Presence] = {}
        for number, (x, y) in enumerate(places.tolist()):
            is_beacon = number < len(beacons)
            neighbors[NodeId(number + 2)] = make_presence(
                x, y, 0.02 if is_beacon else sigma, tick=self.tick, is_beacon=is_beacon
            )
        ranges = np.linalg.norm(places - at, axis=1) + stretch * (np.arange(len(places)) < len(beacons))
        scan = RangeScan(np.array(list(neighbors), dtype=np.int64), ranges)
        return self.localizer.step(self.tick, STILL, fix, scan, neighbors)


def told(x: float, y: float, sigma: float) -> PositionFix:
    return PositionFix(np.array([x, y]), sigma)


def sigmas(estimate: Estimate) -> FloatArray:
    return np.asarray(np.sqrt(np.diag(estimate.covariance)))


@pytest.mark.parametrize("mode", [mode for mode in LpsMode if mode is not LpsMode.COOPERATIVE])
def test_three_beacons_begin_a_belief_and_two_do_not(mode: LpsMode) -> None:
    field = Field(mode)

    assert field.step(TRIANGLE[:2], TRIANGLE[2:]) is None
    assert field.localizer.accepted == 0
    estimate = field.step(TRIANGLE)

    assert estimate is not None
    assert_allclose(estimate.position, TRUTH, atol=1e-6)
    assert_allclose(estimate.velocity, 0.0)
    assert estimate.is_corrected
    assert estimate.shared == 0.0
    assert field.localizer.accepted == 1


@pytest.mark.parametrize("mode", LpsMode)
def test_who_was_told_its_start_believes_that_within_its_sigma(mode: LpsMode) -> None:
    estimate = Field(mode, told(5.0, 6.0, 2.0)).step()

    assert estimate is not None
    assert estimate.position.tolist() == [5.0, 6.0]
    assert sigmas(estimate) == pytest.approx([2.0, 2.0], abs=0.01)
    assert not estimate.is_corrected


@pytest.mark.parametrize("mode", [mode for mode in LpsMode if mode is not LpsMode.COOPERATIVE])
def test_who_was_not_told_has_no_estimate_until_it_can_find_out(mode: LpsMode) -> None:
    field = Field(mode)

    assert all(field.step((), TRIANGLE) is None for _ in range(20))


def test_the_literal_mode_takes_the_covariance_of_the_thesis_whatever_the_geometry() -> None:
    cluster = ((20.0, 0.0), (21.0, 1.5), (21.0, -1.5))
    for beacons in (TRIANGLE, cluster):
        estimate = Field(LpsMode.LITERAL, position_noise_sigma_m=1.7).step(beacons)
        assert estimate is not None
        assert_allclose(estimate.covariance, 1.7**2 * np.eye(2))


def test_the_mode_fixes_takes_the_covariance_of_the_geometry() -> None:
    estimate = Field(LpsMode.FIXES, range_sigma_m=1.5).step(TRIANGLE)

    offsets = TRUTH - np.array(TRIANGLE)
    lines = offsets / np.linalg.norm(offsets, axis=1)[:, None]
    assert estimate is not None
    assert_allclose(estimate.covariance, 1.5**2 * np.linalg.inv(lines.T @ lines), rtol=1e-6)


@pytest.mark.parametrize("mode", BY_FIXES)
@pytest.mark.parametrize("beacons", [TRIANGLE[:1], TRIANGLE[:2]], ids=["one", "two"])
def test_without_three_beacons_the_modes_of_the_thesis_gain_nothing(
    mode: LpsMode, beacons: tuple[tuple[float, float], ...]
) -> None:
    field, alone = Field(mode, told(2.0, 2.0, 1.0)), Field(mode, told(2.0, 2.0, 1.0))
    for _ in range(5):
        estimate, dead_reckoned = field.step(beacons, TRIANGLE), alone.step()

    assert estimate is not None
    assert dead_reckoned is not None
    assert_allclose(estimate.covariance, dead_reckoned.covariance)
    assert not estimate.is_corrected


@pytest.mark.parametrize("mode", BY_RANGES)
def test_one_range_corrects_along_its_line_and_is_no_fix(mode: LpsMode) -> None:
    field = Field(mode, told(5.0, 1.0, 2.0), range_sigma_m=0.5)
    for _ in range(4):
        estimate = field.step(((203.0, 1.0),))

    assert estimate is not None
    assert estimate.position[0] == pytest.approx(3.0, abs=0.2)
    assert sigmas(estimate)[0] < 0.4
    assert sigmas(estimate)[1] > 1.8
    assert not estimate.is_corrected


def test_only_the_cooperative_mode_uses_robots_that_are_no_beacons() -> None:
    variances = {}
    for mode in LpsMode:
        field = Field(mode, told(3.0, 1.0, 2.0))
        for _ in range(3):
            estimate = field.step((), TRIANGLE)
        assert estimate is not None
        assert not estimate.is_corrected
        variances[mode] = float(np.trace(estimate.covariance)), estimate.shared

    (cooperative, shared) = variances.pop(LpsMode.COOPERATIVE)
    assert len(set(variances.values())) == 1
    assert all(cooperative < 0.8 * variance and share == 0.0 for variance, share in variances.values())
    assert shared > 0.0


@pytest.mark.parametrize("mode", LpsMode)
def test_beacons_on_a_line_are_resolved_by_what_is_known_already(mode: LpsMode) -> None:
    unknown = Field(mode).step(LINE)
    assert (unknown is None) == (mode is not LpsMode.COOPERATIVE)
    assert unknown is None or sigmas(unknown).min() > 5.0  # on either side
    field = Field(mode, told(3.5, 1.5, 0.5))
    for _ in range(8):
        estimate = field.step(LINE)

    assert estimate is not None
    assert_allclose(estimate.position, TRUTH, atol=0.5)


@pytest.mark.parametrize(("period", "rounds"), [(0.0, 13), (0.5, 13), (1.0, 7), (3.0, 3)])
def test_the_localization_timer_decides_which_scans_count(period: float, rounds: int) -> None:
    field = Field(LpsMode.FIXES, period_s=period)
    corrected = [field.step(TRIANGLE) for _ in range(13)]

    assert sum(estimate is not None and estimate.is_corrected for estimate in corrected) == rounds
    assert field.localizer.accepted == rounds


def test_a_missed_scan_is_made_good_at_the_next_tick() -> None:
    field = Field(LpsMode.FIXES, period_s=3.0)
    field.step(TRIANGLE)
    for _ in range(6):
        field.step()

    estimate = field.step(TRIANGLE)

    assert estimate is not None
    assert estimate.is_corrected


@pytest.mark.parametrize("mode", BY_RANGES)
def test_a_robot_that_was_told_a_wrong_start_doubts_it_and_finds_out(
    mode: LpsMode, caplog: pytest.LogCaptureFixture
) -> None:
    field = Field(mode, told(30.0, -25.0, 0.3), rejections_max=4)
    beacons = (*TRIANGLE, (0.0, 20.0))

    for _ in range(3):
        estimate = field.step(beacons)
        assert estimate is not None
        assert_allclose(estimate.position, [30.0, -25.0], atol=0.1)  # one round or two may be the ranges' fault
    assert field.localizer.rejected == 12
    for _ in range(100):
        estimate = field.step(beacons)

    assert "filter restarts: 4 localizations in a row" in caplog.text
    assert estimate is not None
    assert_allclose(estimate.position, TRUTH, atol=0.3)


@pytest.mark.parametrize("mode", BY_FIXES)
def test_the_modes_of_the_thesis_restart_at_the_fix(mode: LpsMode) -> None:
    field = Field(mode, told(30.0, -25.0, 0.3), rejections_max=4)

    moved = []
    for _ in range(5):
        estimate = field.step(TRIANGLE)
        assert estimate is not None
        moved.append(float(np.hypot(*(estimate.position - TRUTH))) < 0.5)

    assert moved == [False, False, False, True, True]


def test_a_minority_of_liars_is_outvoted_and_raises_no_doubt(caplog: pytest.LogCaptureFixture) -> None:
    field = Field(LpsMode.COOPERATIVE, told(3.0, 1.0, 0.5))
    for _ in range(20):
        estimate = field.step(((12.0, 14.0),), (*TRIANGLE, (0.0, 20.0)), stretch=25.0)

    assert estimate is not None
    assert_allclose(estimate.position, TRUTH, atol=0.05)
    assert field.localizer.rejected == 20
    assert "restarts" not in caplog.text


def test_after_a_restart_the_shared_error_is_still_shared() -> None:
    field = Field(LpsMode.COOPERATIVE, told(3.0, 1.0, 2.0), rejections_max=1)
    for _ in range(20):
        before = field.step((), (*TRIANGLE, (0.0, 20.0)), sigma=0.2)
    after = field.step(((9.0, 9.0), *TRIANGLE), stretch=40.0)  # all beacons lie at once: doubt

    assert before is not None
    assert after is not None
    assert before.shared > 0.05
    assert np.trace(after.covariance) > 40.0
    kept = after.shared * np.trace(after.covariance) / (before.shared * np.trace(before.covariance))
    assert 1.0 <= kept < 1.3  # a tick of dead reckoning lies between


@pytest.mark.parametrize("mode", LpsMode)
def test_a_beacon_whose_sensor_dies_goes_on_by_ranges_and_stops_calling_itself_one(mode: LpsMode) -> None:
    field = Field(mode)
    for _ in range(4):
        field.step(TRIANGLE, fix=told(3.0, 1.0, 0.02))
    assert field.localizer.is_beacon

    memory = [field.step(TRIANGLE) is not None and field.localizer.is_beacon for _ in range(20)]
    estimate = field.step(TRIANGLE)

    assert memory == [n < round(BEACON_MEMORY_S / DT) for n in range(20)]
    assert estimate is not None
    assert estimate.is_corrected
    assert_allclose(estimate.position, TRUTH, atol=0.1)
    field.step(fix=told(3.0, 1.0, 0.02))
    assert field.localizer.is_beacon


@pytest.mark.parametrize("broken", [told(math.nan, 0.0, 0.02), told(3.0, 1.0, math.inf), told(900.0, 900.0, 0.02)])
def test_a_sensor_that_talks_nonsense_makes_no_beacon(broken: PositionFix) -> None:
    field = Field(LpsMode.COOPERATIVE, told(3.0, 1.0, 0.5), rejections_max=100)
    for _ in range(20):
        estimate = field.step(TRIANGLE, fix=broken)
        assert not field.localizer.is_beacon

    assert estimate is not None
    assert_allclose(estimate.position, TRUTH, atol=0.5)


@pytest.mark.parametrize("mode", LpsMode)
def test_who_ranges_is_no_beacon(mode: LpsMode) -> None:
    field = Field(mode, told(3.0, 1.0, 0.5))
    for _ in range(5):
        field.step(TRIANGLE)
        assert not field.localizer.is_beacon


@pytest.mark.parametrize("mode", LpsMode)
def test_ranges_without_noise_do_not_break_the_filter(mode: LpsMode) -> None:
    field = Field(mode, range_sigma_m=1e-6, position_noise_sigma_m=1e-6)
    for _ in range(50):
        estimate = field.step(TRIANGLE, ((1.0, 15.0), (3.0, 1.0)), sigma=0.0)

    assert estimate is not None
    assert np.isfinite(estimate.covariance).all()
    assert np.linalg.eigvalsh(estimate.covariance).min() >= 0.0
    assert_allclose(estimate.position, TRUTH, atol=1e-3)


def test_hellos_that_are_too_old_end_the_localization() -> None:
    localizer = Localizer(LpsConfig(), DT)
    neighbors = {NodeId(n): make_presence(x, y, 0.02, tick=0) for n, (x, y) in enumerate(TRIANGLE)}
    scan = RangeScan(np.arange(3), np.linalg.norm(np.array(TRIANGLE) - TRUTH, axis=1))

    corrected = []
    for tick in range(12):
        estimate = localizer.step(tick, STILL, None, scan, neighbors)
        corrected.append(estimate is not None and estimate.is_corrected)

    assert corrected == [True] * 9 + [False] * 3


@pytest.mark.parametrize("mode", LpsMode)
def test_equal_inputs_give_equal_bytes_in_every_mode(mode: LpsMode) -> None:
    def run() -> bytes:
        field = Field(mode, told(2.0, 2.0, 2.0))
        estimates = [field.step(TRIANGLE, ((1.0, 15.0),), stretch=0.1 * n) for n in range(10)]
        return b"".join(e.position.tobytes() + e.covariance.tobytes() for e in estimates if e is not None)

    assert run() == run()
    assert len(run()) == 10 * 6 * 8


@pytest.mark.parametrize("mode", LpsMode)
@pytest.mark.parametrize("absurd", [1e6, 1e154, 1e300])
@pytest.mark.parametrize("sigma", [0.5, 8.0], ids=["sure of its start", "unsure of its start"])
def test_absurd_ranges_are_survived(mode: LpsMode, absurd: float, sigma: float) -> None:
    field = Field(mode, told(3.0, 1.0, sigma))
    with np.errstate(over="ignore"):
        for n in range(3):
            estimate = field.step(TRIANGLE, ((1.0, 15.0), (3.0, 1.0)), stretch=absurd if n else 0.0)

    assert estimate is not None
    assert np.isfinite(estimate.position).all()
    assert np.isfinite(estimate.covariance).all()
    assert np.hypot(*(estimate.position - TRUTH)) < 4.0 * sigma
