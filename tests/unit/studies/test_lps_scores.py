from __future__ import annotations

import numpy as np
import pytest

from studies.lps_scores import score

TICKS, ROBOTS = 400, 50


def estimates_with(sigma: float) -> tuple[np.ndarray, np.ndarray]:
    truth = np.full((TICKS, ROBOTS, 2), 3.0)
    noise = np.random.default_rng(1).normal(size=truth.shape)
    return truth + sigma * noise, truth


def claimed(sigma: float) -> np.ndarray:
    return np.broadcast_to(sigma**2 * np.eye(2), (TICKS, ROBOTS, 2, 2))


EVERYTHING = np.ones((TICKS, ROBOTS), dtype=bool)


def test_a_filter_that_claims_what_it_achieves_is_in_the_band_95_times_in_100() -> None:
    estimates, truth = estimates_with(0.5)

    scores = score(estimates, claimed(0.5), truth, EVERYTHING, EVERYTHING)

    assert scores.nees_share == pytest.approx(0.95, abs=0.005)
    assert scores.nees_mean == pytest.approx(2.0, abs=0.05)
    assert scores.rms_m == pytest.approx(0.5 * np.sqrt(2.0), rel=0.02)
    assert scores.samples == TICKS * ROBOTS


def test_a_filter_that_claims_half_its_error_has_four_times_the_nees() -> None:
    estimates, truth = estimates_with(1.0)

    scores = score(estimates, claimed(0.5), truth, EVERYTHING, EVERYTHING)

    assert scores.nees_mean == pytest.approx(8.0, abs=0.2)
    assert scores.nees_share is not None
    assert scores.nees_share < 0.7


def test_only_what_counts_and_is_known_is_scored() -> None:
    estimates, truth = estimates_with(0.0)
    estimates[:, 1] += 4.0  # does not count
    estimates[:, 2] = np.nan  # unknown
    estimates[:, 3] += (3.0, 4.0)
    counts = EVERYTHING.copy()
    counts[:, 1] = False

    scores = score(estimates, claimed(1.0), truth, counts, EVERYTHING)

    assert scores.samples == TICKS * (ROBOTS - 2)
    assert scores.max_m == pytest.approx(5.0)
    assert scores.nees_mean == pytest.approx(25.0 / (ROBOTS - 2))


def test_without_samples_there_are_no_numbers() -> None:
    estimates, truth = estimates_with(1.0)

    scores = score(estimates, claimed(1.0), truth, np.zeros_like(EVERYTHING), EVERYTHING)

    assert scores.samples == 0
    assert {scores.rms_m, scores.p99_m, scores.max_m, scores.nees_share, scores.nees_mean} == {None}


def test_a_lost_robot_is_told_apart_but_must_be_honest_too() -> None:
    estimates, truth = estimates_with(0.0)
    estimates[:, 0] += (30.0, 40.0)
    localized = EVERYTHING.copy()
    localized[:, 0] = False

    scores = score(estimates, claimed(1.0), truth, EVERYTHING, localized)

    assert (scores.rms_m, scores.max_m) == (0.0, 0.0)
    assert scores.lost_share == pytest.approx(1.0 / ROBOTS)
    assert scores.lost_rms_m == pytest.approx(50.0)
    assert scores.nees_mean == pytest.approx(2500.0 / ROBOTS)
