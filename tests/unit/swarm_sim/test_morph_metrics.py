"""How well a swarm follows a shape, on cases that can be told by hand."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics.morphing import STEP, MorphMetrics, morph_metrics

SQUARE = np.array([[0.0, 0.0], [12.0, 0.0], [12.0, 12.0], [0.0, 12.0]])
LATTICE = np.array([[x, y] for x in (1.0, 3.0, 5.0, 7.0, 9.0, 11.0) for y in (1.0, 3.0, 5.0, 7.0, 9.0, 11.0)])
SPEED, BEGINS, ENDS, LAST = 0.4, 30.0, 60.0, 90.0
RIGHT = np.array([1.0, 0.0])
TIMES = np.arange(0.0, LAST + 0.05, 0.1)


def way(time: float) -> FloatArray:
    return SPEED * (min(max(time, BEGINS), ENDS) - BEGINS) * RIGHT


def contour_of(time: float) -> FloatArray:
    return SQUARE + way(time)


def follow(positions: FloatArray) -> MorphMetrics:
    return morph_metrics(TIMES, positions, contour_of, BEGINS, ENDS)


def behind(delay: float, robots: FloatArray = LATTICE) -> FloatArray:
    return np.array([robots + way(time - delay) for time in TIMES])


@pytest.mark.parametrize("delay", [0.0, 1.0, 4.5, 12.0])
def test_a_swarm_that_follows_exactly_with_a_delay_has_that_latency(delay: float) -> None:
    assert (
        delay - 2.0 * STEP <= follow(behind(delay)).latency_s <= delay
    )  # the least lag that the grid does not exclude


def test_a_swarm_that_is_always_there_has_nothing_outside_and_nothing_to_recover_from() -> None:
    metrics = follow(behind(0.0))

    assert (metrics.outside_mean, metrics.outside_max, metrics.recovery_s) == (0.0, 0.0, 0.0)
    assert metrics.uncovered_mean < 0.01


def test_robots_outside_are_counted_over_the_motion() -> None:
    metrics = follow(behind(5.0))  # 2 m behind, from the fifth second on: the left column has 1 m to spare

    assert metrics.outside_max == pytest.approx(1 / 6)
    assert metrics.outside_mean == pytest.approx((1 / 6) * (30.0 - 2.5) / 30.0, abs=0.005)


def test_recovery_is_the_time_until_the_last_one_is_inside() -> None:
    positions = behind(0.0)
    positions[:, 2] = behind(8.0)[:, 2]  # of the left column; 1 m of its last 3.2 m is to go when it comes in

    metrics = follow(positions)

    assert metrics.recovery_s == pytest.approx(8.0 - 1.0 / SPEED, abs=2 * STEP)


def test_a_swarm_that_stays_behind_never_recovers() -> None:
    positions = np.broadcast_to(LATTICE, (len(TIMES), *LATTICE.shape))

    metrics = follow(positions)

    assert metrics.recovery_s is None
    assert metrics.outside_max == 1.0


def test_one_robot_that_covers_little_leaves_the_rest_uncovered() -> None:
    reach = 0.65 * np.sqrt(2.0 * 144.0 / np.sqrt(3.0))  # of one robot alone in 144 m2
    corner = SQUARE[:1] + 0.01

    metrics = follow(behind(0.0, corner))

    assert metrics.uncovered_mean == pytest.approx(1.0 - np.pi * reach**2 / 4.0 / 144.0, abs=0.005)


def test_recovery_waits_for_what_is_uncovered() -> None:
    positions = behind(0.0)
    late = (TIMES > ENDS - 1.0) & (TIMES < ENDS + 6.0)
    positions[late, :12] = positions[late][:, 12:24] - 0.5  # two columns stand beside others until 6 s after the end

    metrics = follow(positions)

    assert metrics.outside_max == 0.0
    assert metrics.recovery_s == pytest.approx(6.0, abs=2 * STEP)


@pytest.mark.parametrize("shift", [0.0, 0.05, 0.3])
def test_a_swarm_that_follows_a_shape_exactly_is_not_late_however_little_that_moves(shift: float) -> None:
    share = shift / (SPEED * (ENDS - BEGINS))
    positions = LATTICE + share * (behind(0.0) - LATTICE)

    metrics = morph_metrics(TIMES, positions, lambda time: SQUARE + share * way(time), BEGINS, ENDS)

    assert metrics.latency_s == 0.0


def test_lags_that_fit_alike_but_for_what_the_grid_resolves_count_as_none() -> None:
    slowly = behind(0.1)  # 4 cm behind, a third of a percent of the shape

    assert follow(slowly).latency_s == 0.0
    assert follow(behind(2.0)).latency_s >= 1.5


def test_a_motion_until_the_last_moment_but_for_rounding_is_within_the_record() -> None:
    metrics = morph_metrics(TIMES, behind(0.0), contour_of, TIMES[0] - 1e-12, TIMES[-1] + 1e-12)

    assert metrics.outside_max == 0.0


@pytest.mark.parametrize(("begins", "ends"), [(-1.0, 60.0), (30.0, 91.0), (60.0, 30.0)])
def test_a_motion_outside_the_record_is_refused(begins: float, ends: float) -> None:
    with pytest.raises(ValueError, match="in a record from 0 to 90 s"):
        morph_metrics(TIMES, behind(0.0), contour_of, begins, ends)
