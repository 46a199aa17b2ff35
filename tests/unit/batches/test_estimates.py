from __future__ import annotations

import math

import pytest

from batches.estimates import estimate, paired_difference, share


def test_mean_deviation_and_interval_of_a_closed_case() -> None:
    found = estimate([1.0, 2.0, 3.0, 4.0])

    assert found is not None
    half = 3.182446 * math.sqrt(5.0 / 3.0) / 2.0  # t of 3 degrees of freedom at 97.5 %, from any table
    assert found.mean == 2.5
    assert found.deviation == pytest.approx(math.sqrt(5.0 / 3.0))
    assert (found.low, found.high) == (pytest.approx(2.5 - half, abs=1e-6), pytest.approx(2.5 + half, abs=1e-6))
    assert found.count == 4


def test_the_worst_is_the_largest_unless_small_is_bad() -> None:
    larger, smaller = estimate([1.0, 3.0, 2.0]), estimate([1.0, 3.0, 2.0], is_larger_worse=False)

    assert larger is not None
    assert smaller is not None
    assert (larger.worst, smaller.worst) == (3.0, 1.0)


def test_one_run_has_a_mean_and_nothing_more() -> None:
    found = estimate([7.0])

    assert found is not None
    assert (found.mean, found.deviation, found.low, found.high, found.worst) == (7.0, None, None, None, 7.0)


def test_no_run_is_no_estimate() -> None:
    assert estimate([]) is None
    assert share([]) is None
    assert paired_difference([], []) is None


def test_a_share_has_the_score_interval_of_wilson() -> None:
    found = share([True] * 8 + [False] * 2)

    assert found is not None
    z, n, p = 1.959964, 10, 0.8
    center = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * math.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    assert found.mean == 0.8
    assert (found.low, found.high) == (pytest.approx(center - half, abs=1e-6), pytest.approx(center + half, abs=1e-6))


def test_a_share_of_all_is_still_uncertain() -> None:
    found = share([True] * 20)

    assert found is not None
    assert found.high == pytest.approx(1.0)
    assert found.low is not None
    assert found.low < 0.9


def test_pairs_take_out_what_a_start_does_to_both() -> None:
    first = [10.0, 20.0, 30.0, 40.0]
    found = paired_difference(first, [value + 1.0 for value in first])

    assert found is not None
    assert (found.mean, found.deviation, found.low, found.high, found.count) == (1.0, 0.0, 1.0, 1.0, 4)


def test_pairs_must_be_pairs() -> None:
    with pytest.raises(ValueError, match="shorter"):
        paired_difference([1.0, 2.0], [1.0])
