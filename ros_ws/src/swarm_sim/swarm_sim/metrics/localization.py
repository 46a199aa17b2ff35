"""How well the robots knew where they were, and how well they knew that (spec section 14.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.types import BoolArray, FloatArray

NEES_BAND = (0.0506356, 7.3777589)
"""Two-sided 95 % band of chi-square with two degrees of freedom."""


@dataclass(frozen=True, slots=True)
class LocalizationError:
    """Statistics over robots and ticks, None where nobody reported a position.

    Attributes
    ----------
    rmse, p99, maximum : float or None
        Of the error norm [m].
    consistent : float or None
        Share of the estimates whose normalized estimation error squared (NEES) lies in `NEES_BAND`: 0.95 for a filter
        that claims what it achieves; less for one that claims too much or far too little.
    """

    rmse: float | None
    p99: float | None
    maximum: float | None
    consistent: float | None


def localization_error(
    estimates: FloatArray, covariances: FloatArray, truth: FloatArray, counts: BoolArray
) -> LocalizationError:
    """Return the statistics of estimate - truth.

    Parameters
    ----------
    estimates : (t, n, 2) array
        NaN where a robot reported no position [m].
    covariances : (t, n, 2, 2) array
        What the robots believed of their errors [m^2].
    truth : (t, n, 2) array
        True positions at the same instants [m].
    counts : (t, n) bool array
        Which entries count: live robots, of the kind and after the warm-up that are asked for.
    """
    counts = counts & np.isfinite(estimates).all(axis=2)
    errors = (estimates - truth)[counts]
    if not len(errors):
        return LocalizationError(None, None, None, None)
    norms = np.hypot(errors[:, 0], errors[:, 1])
    return LocalizationError(
        float(np.sqrt((norms**2).mean())),
        float(np.percentile(norms, 99.0)),
        float(norms.max()),
        consistent_share(normalized_squares(errors, covariances[counts])),
    )


def normalized_squares(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the normalized estimation error squared, e^T P^-1 e, shape (k,).

    Parameters
    ----------
    errors : (k, 2) array
        Estimate minus truth [m].
    covariances : (k, 2, 2) array
        As believed, positive definite [m^2].
    """
    squares: FloatArray = (errors * np.linalg.solve(covariances, errors[..., None])[..., 0]).sum(axis=1)
    return squares


def consistent_share(squares: FloatArray) -> float:
    """Return the share of normalized squares, shape (k,), that lie in `NEES_BAND`."""
    low, high = NEES_BAND
    return float(((squares >= low) & (squares <= high)).mean())
