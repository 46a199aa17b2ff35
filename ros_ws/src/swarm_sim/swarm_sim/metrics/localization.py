"""How well the robots knew where they were (spec section 14.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True)
class LocalizationError:
    """Error norms over robots and ticks, None where nobody reported a position [m]."""

    rmse: float | None
    p99: float | None
    maximum: float | None


def localization_error(estimates: FloatArray, truth: FloatArray, counts: np.ndarray) -> LocalizationError:
    """Return the statistics of |estimate - truth|.

    Parameters
    ----------
    estimates : (t, n, 2) array
        NaN where a robot reported no position [m].
    truth : (t, n, 2) array
        True positions at the same instants [m].
    counts : (t, n) bool array
        Which entries count: live robots, of the kind and after the warm-up that are asked for.
    """
    errors = np.linalg.norm(estimates - truth, axis=2)[counts]
    errors = errors[np.isfinite(errors)]
    if not len(errors):
        return LocalizationError(None, None, None)
    return LocalizationError(
        float(np.sqrt((errors**2).mean())), float(np.percentile(errors, 99.0)), float(errors.max())
    )
