"""How good and how honest position estimates were: error statistics and consistency of one run (spec section 14.5)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.metrics.localization import localization_error, normalized_squares


@dataclass(frozen=True, slots=True, kw_only=True)
class Scores:
    """What one run of one cell came to; None is a number that does not apply.

    Attributes
    ----------
    rms_m, p99_m, max_m : float or None
        Error norms of the robots that are no beacons and are localized, over robots and ticks after the warm-up [m].
    lost_share : float or None
        Share of the samples in which they are lost, by the rule of their mode (spec section 6).
    lost_rms_m : float or None
        Their error then, by dead reckoning [m].
    nees_share : float or None
        Share of all samples, localized or lost, whose normalized estimation error squared lies inside its 95 % band.
    nees_mean : float or None
        Mean of it: 2 for a consistent filter, more for one that is too sure of itself.
    samples : int
        How many there were.
    achieved : bool or None
        Whether the mission was; this and the rest belong to experiment `mission`.
    collisions : int or None
    displacement_ratio : float or None
        Displacement over its lower bound.
    settling_ratio : float or None
        Settling time over the bottleneck time.
    """

    rms_m: float | None
    p99_m: float | None
    max_m: float | None
    lost_share: float | None
    lost_rms_m: float | None
    nees_share: float | None
    nees_mean: float | None
    samples: int
    achieved: bool | None = None
    collisions: int | None = None
    displacement_ratio: float | None = None
    settling_ratio: float | None = None

    def as_record(self) -> Mapping[str, float | None]:
        """Return plain data for a line of JSON."""
        return asdict(self)


def score(
    estimates: FloatArray, covariances: FloatArray, truth: FloatArray, counts: BoolArray, is_localized: BoolArray
) -> Scores:
    """Return the statistics of a run.

    Parameters
    ----------
    estimates : (t, n, 2) array
        NaN where a robot had none [m].
    covariances : (t, n, 2, 2) array
        Of the estimates [m^2].
    truth : (t, n, 2) array
        True positions at the same instants [m].
    counts : (t, n) bool array
        Which samples count.
    is_localized : (t, n) bool array
        In which of them the robot was not lost. Errors are told apart by that (spec section 14.5): those of a lost
        robot say how long it has been lost, not how good a fix is. Consistency is asked of both.
    """
    counts = counts & np.isfinite(estimates).all(axis=2)
    samples, lost = int(counts.sum()), counts & ~is_localized
    error = localization_error(estimates, covariances, truth, counts & is_localized)
    every = localization_error(estimates, covariances, truth, counts)
    return Scores(
        rms_m=error.rmse,
        p99_m=error.p99,
        max_m=error.maximum,
        lost_share=float(lost.sum()) / samples if samples else None,
        lost_rms_m=localization_error(estimates, covariances, truth, lost).rmse,
        nees_share=every.consistent,
        nees_mean=_nees_mean(estimates, covariances, truth, counts),
        samples=samples,
    )


def _nees_mean(estimates: FloatArray, covariances: FloatArray, truth: FloatArray, counts: BoolArray) -> float | None:
    """Return the mean normalized estimation error squared of the samples that count; None without any."""
    squares = normalized_squares((estimates - truth)[counts], covariances[counts])
    return float(squares.mean()) if len(squares) else None
