"""Means over random starts, and how far they can be trusted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

LEVEL = 0.95
"""Confidence of all intervals."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A mean over runs.

    Attributes
    ----------
    mean : float
    deviation : float or None
        Standard deviation of one run, from the sample; None for a single run.
    low, high : float or None
        Confidence interval of the mean at `LEVEL`; None for a single run.
    worst : float
        Of all runs.
    count : int
        Runs that have the number.
    """

    mean: float
    deviation: float | None
    low: float | None
    high: float | None
    worst: float
    count: int


def estimate(values: Sequence[float], *, is_larger_worse: bool = True) -> Estimate | None:
    """Return mean and Student's t interval; None without values.

    The interval is exact for normal values, and close for others where the runs are many (central limit theorem).
    """
    if not values:
        return None
    sample = np.asarray(values, dtype=np.float64)
    mean, worst = float(sample.mean()), float(sample.max() if is_larger_worse else sample.min())
    if len(sample) == 1:
        return Estimate(mean, None, None, None, worst, 1)
    deviation = float(sample.std(ddof=1))
    half = float(stats.t.ppf(0.5 + 0.5 * LEVEL, len(sample) - 1)) * deviation / math.sqrt(len(sample))
    return Estimate(mean, deviation, mean - half, mean + half, worst, len(sample))


def share(outcomes: Sequence[bool]) -> Estimate | None:
    """Return the share of true outcomes with Wilson's score interval; None without outcomes.

    Unlike the interval of a mean it stays within 0 and 1, and has a width where all runs end alike.
    """
    if not outcomes:
        return None
    count, hits = len(outcomes), sum(outcomes)
    interval = stats.binomtest(hits, count).proportion_ci(LEVEL, method="wilson")
    deviation = math.sqrt(hits / count * (1.0 - hits / count) * count / (count - 1)) if count > 1 else None
    return Estimate(hits / count, deviation, float(interval.low), float(interval.high), float(min(outcomes)), count)


def paired_difference(first: Sequence[float], second: Sequence[float]) -> Estimate | None:
    """Return how much larger the second numbers are than the first, run by run, with Student's t interval.

    Parameters
    ----------
    first, second : sequence of float
        Of the same starts, in the same order. Pairs take out what a start makes easy or hard for every method.
    """
    return estimate([after - before for before, after in zip(first, second, strict=True)])
