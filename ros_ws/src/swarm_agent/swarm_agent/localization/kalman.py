"""The two steps of a linear Kalman filter, as pure functions on a frozen state of any dimension.

Products are spelled ``a.dot(b)``: of matrices this small, ``a @ b`` takes twice as long for the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Gaussian:
    """Belief about a state.

    Attributes
    ----------
    mean : (n,) array
    covariance : (n, n) array
    """

    mean: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Innovation:
    """What a measurement says that the prediction did not.

    Attributes
    ----------
    residual : (m,) array
        Measurement minus its prediction.
    cross : (n, m) array
        Covariance of the state and the residual, P H^T.
    information : (m, m) array
        Inverse of the residual's covariance.
    squared : float
        Normalized innovation squared: chi-square with m degrees of freedom if the filter is consistent.
    """

    residual: FloatArray
    cross: FloatArray
    information: FloatArray
    squared: float


def predict(belief: Gaussian, transition: FloatArray, drive: FloatArray, noise: FloatArray) -> Gaussian:
    """Return the belief one step later.

    Parameters
    ----------
    belief : Gaussian
        Of dimension n.
    transition : (n, n) array
        F.
    drive : (n,) array
        B u, what the known input adds.
    noise : (n, n) array
        Q.
    """
    mean = transition.dot(belief.mean) + drive
    return Gaussian(mean, transition.dot(belief.covariance).dot(transition.T) + noise)


def innovation(belief: Gaussian, residual: FloatArray, observation: FloatArray, noise: FloatArray) -> Innovation:
    """Return how surprising a measurement is.

    Parameters
    ----------
    belief : Gaussian
        Of dimension n.
    residual : (m,) array
        z - h(mean).
    observation : (m, n) array
        H, or the Jacobian of h at the mean.
    noise : (m, m) array
        R.
    """
    cross = belief.covariance.dot(observation.T)
    information = _inverse(observation.dot(cross) + noise)
    return Innovation(residual, cross, information, float(residual.dot(information).dot(residual)))


def correct(belief: Gaussian, surprise: Innovation, observation: FloatArray, noise: FloatArray) -> Gaussian:
    """Return the belief after a measurement.

    The covariance takes Joseph's form, (I - K H) P (I - K H)^T + K R K^T, which stays symmetric and positive
    semi-definite in the face of rounding.

    Parameters
    ----------
    belief : Gaussian
        Of dimension n.
    surprise : Innovation
        Of this belief and measurement.
    observation : (m, n) array
        H, as in `innovation`.
    noise : (m, m) array
        R, as in `innovation`.

    References
    ----------
    .. [1] R. S. Bucy and P. D. Joseph, "Filtering for stochastic processes with applications to guidance", 1968.
    """
    gain = surprise.cross.dot(surprise.information)
    keep = _identity(len(gain)) - gain.dot(observation)
    covariance = keep.dot(belief.covariance).dot(keep.T) + gain.dot(noise).dot(gain.T)
    # Products of three matrices are symmetric only up to rounding; without this the difference grows over hours.
    covariance = 0.5 * (covariance + covariance.T)
    return Gaussian(belief.mean + gain.dot(surprise.residual), covariance)


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return the inverse of a symmetric positive definite matrix."""
    if len(matrix) != 2:
        general: FloatArray = np.linalg.inv(matrix).astype(np.float64, copy=False)
        return general
    # A position is the everyday case, and a call of LAPACK costs more than the rest of the correction.
    (a, b), (_, c) = matrix.tolist()
    scale = 1.0 / (a * c - b * b)
    return np.array(((c * scale, -b * scale), (-b * scale, a * scale)))


@cache
def _identity(dimension: int) -> FloatArray:
    identity = np.eye(dimension)
    identity.flags.writeable = False
    return identity
