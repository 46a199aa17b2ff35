from __future__ import annotations

import numpy as np
import pytest
from tick_builders import PERIOD, SAMPLES, make_tick

from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.contacts import count_contacts
from swarm_sim.metrics.localization import consistent_share, localization_error, normalized_squares
from swarm_sim.metrics.trace import NOTHING, TraceRecorder

ROBOTS = (NodeId(0), NodeId(1))


def test_a_trace_has_the_start_and_every_sample_in_time() -> None:
    recorder = TraceRecorder(ROBOTS, PERIOD)
    for tick in range(3):
        record = make_tick(tick, [[tick, 0.0], [tick, 1.0]])
        recorder.record(record.truth, record.reports)
    trace = recorder.trace()

    assert trace.sample_times == pytest.approx(np.arange(3 * SAMPLES + 1) * PERIOD / SAMPLES)
    assert trace.sample_rate == pytest.approx(SAMPLES / PERIOD)
    assert trace.positions.shape == (3 * SAMPLES + 1, 2, 2)
    assert trace.positions[[0, 1, SAMPLES + 1], 0, 0].tolist() == [0.0, 0.0, 1.0]
    assert trace.tick_positions[:, 0, 0].tolist() == [0.0, 1.0, 2.0]


def test_a_robot_that_did_not_report_has_no_estimate_mode_or_goal() -> None:
    recorder = TraceRecorder(ROBOTS, PERIOD)
    record = make_tick(0, [[0.0, 0.0], [1.0, 0.0]], lost=frozenset({NodeId(1)}))
    recorder.record(record.truth, record.reports)
    trace = recorder.trace()

    assert np.isnan(trace.estimates[0, 1]).all()
    assert (trace.modes[0, 1], trace.goals[0, 1]) == (NOTHING, NOTHING)
    assert trace.alive.tolist() == [[True, False]]


def test_a_run_without_a_tick_is_a_trace_with_empty_axes() -> None:
    trace = TraceRecorder(ROBOTS, PERIOD).trace()

    assert trace.positions.shape == (0, 2, 2)
    assert trace.alive.shape == (0, 2)
    assert trace.sample_rate == 0.0


def test_totals_add_up_over_the_ticks() -> None:
    recorder = TraceRecorder(ROBOTS, PERIOD)
    for tick, clearance in enumerate([0.5, -0.1, 0.3]):
        record = make_tick(tick, [[0, 0], [1, 0]], clearance=clearance, overlaps=((0, 1),) if clearance < 0 else ())
        recorder.record(record.truth, record.reports)
    totals = recorder.totals()

    assert (totals.contacts, totals.min_clearance) == (1, -0.1)
    assert (totals.radio_frames, totals.radio_bytes, totals.radio_dropped) == (6, 60, 3)
    assert (totals.radio_peak_bps, totals.radio_neighborhood_peak_bps) == (160.0, 240.0)


def test_a_lone_robot_has_no_clearance() -> None:
    recorder = TraceRecorder(ROBOTS[:1], PERIOD)
    record = make_tick(0, [[0, 0]], clearance=np.inf)
    recorder.record(record.truth, record.reports)

    assert recorder.totals().min_clearance is None


@pytest.mark.parametrize(
    ("overlaps", "episodes"),
    [
        ([(), ()], 0),
        ([((0, 1),), ((0, 1),), ((0, 1),)], 1),
        ([((0, 1),), (), ((0, 1),)], 2),
        ([((0, 1),), ((1, 0),)], 1),
        ([((0, 1), (0, -1)), ((0, 1), (2, 3))], 3),
    ],
    ids=["none", "one long", "parted and back", "named the other way", "robots and wall"],
)
def test_a_contact_is_counted_once_until_the_pair_parts(
    overlaps: list[tuple[tuple[int, int], ...]], episodes: int
) -> None:
    assert count_contacts(overlaps) == episodes


def test_localization_error_counts_what_it_is_asked_to_and_what_was_reported() -> None:
    truth = np.zeros((2, 3, 2))
    estimates = np.array([[[3.0, 4.0], [np.nan, np.nan], [9.0, 9.0]], [[0.0, 0.0], [0.0, 1.0], [9.0, 9.0]]])
    counts = np.array([[True, True, False], [True, True, False]])

    covariances = np.tile(np.eye(2), (2, 3, 1, 1))
    covariances[0, 0] *= 25.0  # this one knows what it does not know; the one at the truth claims far too little

    error = localization_error(estimates, covariances, truth, counts)

    assert error.consistent == pytest.approx(2.0 / 3.0)
    assert error.rmse == pytest.approx(np.sqrt((25.0 + 0.0 + 1.0) / 3.0))
    assert error.maximum == 5.0


def test_nobody_who_reports_is_no_error_at_all() -> None:
    unknown = np.full((2, 1, 2), np.nan)
    error = localization_error(unknown, np.ones((2, 1, 2, 2)), np.zeros((2, 1, 2)), np.ones((2, 1), dtype=bool))

    assert (error.rmse, error.p99, error.maximum, error.consistent) == (None, None, None, None)


def test_a_perfect_filter_lies_in_the_band_nineteen_times_out_of_twenty() -> None:
    rng = np.random.default_rng(1)
    spread = rng.normal(size=(20000, 2, 2))
    covariances = spread @ spread.transpose(0, 2, 1) + 0.1 * np.eye(2)
    errors = (np.linalg.cholesky(covariances) @ rng.normal(size=(20000, 2, 1)))[..., 0]

    squares = normalized_squares(errors, covariances)

    assert squares.mean() == pytest.approx(2.0, rel=0.03)
    assert consistent_share(squares) == pytest.approx(0.95, abs=0.01)
    assert consistent_share(normalized_squares(2.0 * errors, covariances)) < 0.85
