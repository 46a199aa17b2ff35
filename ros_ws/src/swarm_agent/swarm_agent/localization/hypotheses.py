"""Several beliefs at once, where one ellipse is not the truth: a sum of Gaussians (Sorenson and Alspach, 1971).

A robot that is uncertain by as much as its neighbors are away cannot linearize a range: the circle that it measures
bends within its own ellipse, and two or three circles may meet in two places. A single Kalman filter then picks
one, often the wrong one, and is soon sure of it. So a wide belief is split into seven narrow ones, in the middle and
around it. Each goes through the same filter; the ranges tell which of them predict well. As soon as the rest has become
improbable, or all mean the same place, there is one again: within a few rounds of ranging where ranges are to be had.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_agent.localization.kalman import Gaussian
from swarm_agent.localization.motion_model import POSITION
from swarm_agent.localization.range_fusion import SplitBelief
from swarm_msgs_py.types import FloatArray

WIDE_M = 1.0
"""A belief whose position is uncertain by more than this, in any direction, is split before ranges correct it."""

_REGULAR = 1e-9
"""Share of its variance that keeps a position that is certain in one direction invertible."""

RING = 6
"""Hypotheses around the one in the middle."""

NARROWING = 0.6
"""Standard deviation of a hypothesis, as a share of the belief that it was split from."""

_RADIUS = math.sqrt(2.0 * (1.0 - NARROWING**2) * (RING + 1) / RING)
"""Distance of the ring in standard deviations, such that the sum has the covariance of the whole."""

_ANGLES = np.arange(RING) * math.tau / RING
_PLACES: FloatArray = np.vstack([np.zeros((1, 2)), _RADIUS * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)])

IMPROBABLE = 1e-3
"""A hypothesis with less weight than this is dropped."""

SAME = 0.5
"""Hypotheses are one if their places differ, root mean square, by less than this many of their standard deviations."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """One of several beliefs.

    Attributes
    ----------
    weight : float
        Its probability; those of all hypotheses sum to 1.
    belief : SplitBelief
    """

    weight: float
    belief: SplitBelief


Hypotheses = tuple[Hypothesis, ...]


def certain(belief: SplitBelief) -> Hypotheses:
    """Return a belief without alternative."""
    return (Hypothesis(1.0, belief),)


def divided(hypotheses: Hypotheses) -> Hypotheses:
    """Return the hypotheses, split into narrow ones if there is only one, and that is wide.

    Only the robot's own part of the error is split: of what it shares with its neighbors, their ranges tell nothing.
    """
    belief = hypotheses[0].belief
    covariance, is_own = belief.gaussian.covariance, 1.0 - belief.shared
    columns, position = covariance[:, POSITION], covariance[POSITION, POSITION]
    if len(hypotheses) > 1 or math.sqrt(is_own) * widest(position) <= WIDE_M:
        return hypotheses
    position = position + _REGULAR * position.trace() * np.eye(2)
    follow = columns @ np.linalg.inv(position)  # how the whole state moves with the position
    narrow = covariance - (1.0 - NARROWING**2) * is_own * (follow @ columns.T)
    narrow = 0.5 * (narrow + narrow.T)
    shared = belief.shared * float(position.trace()) / float(narrow[POSITION, POSITION].trace())
    shifts = _PLACES @ (math.sqrt(is_own) * np.linalg.cholesky(position)).T @ follow.T
    mean = belief.gaussian.mean
    return tuple(
        Hypothesis(1.0 / len(shifts), SplitBelief(Gaussian(mean + shift, narrow), min(shared, 1.0))) for shift in shifts
    )


def reweighed(hypotheses: Iterable[tuple[Hypothesis, SplitBelief, float]]) -> Hypotheses:
    """Return what is left of the hypotheses after a measurement.

    Parameters
    ----------
    hypotheses : iterable of (Hypothesis, SplitBelief, float)
        Each one before, its belief after, and the logarithm of the probability that it gave to the measurement.
    """
    told = list(hypotheses)
    if len(told) == 1:
        return certain(told[0][1])
    logs = np.array([math.log(before.weight) + told_log for before, _, told_log in told])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    kept = [
        (weight, after) for weight, (_, after, _) in zip(weights.tolist(), told, strict=True) if weight > IMPROBABLE
    ]
    total = sum(weight for weight, _ in kept)
    left = tuple(Hypothesis(weight / total, after) for weight, after in kept)
    return certain(merged(left)) if len(left) > 1 and _mean_the_same(left) else left


def merged(hypotheses: Hypotheses) -> SplitBelief:
    """Return the one belief with the mean and the covariance of all hypotheses together."""
    if len(hypotheses) == 1:
        return hypotheses[0].belief
    weights, means = _means(hypotheses)
    mean = weights @ means
    apart = means - mean
    covariance = (apart * weights[:, None]).T @ apart
    shared = 0.0
    for hypothesis in hypotheses:
        inner = hypothesis.belief.gaussian.covariance
        covariance = covariance + hypothesis.weight * inner
        shared += hypothesis.weight * hypothesis.belief.shared * float(inner[POSITION, POSITION].trace())
    return SplitBelief(Gaussian(mean, covariance), shared / float(covariance[POSITION, POSITION].trace()))


def widest(covariance: FloatArray) -> float:
    """Return the standard deviation along the long axis of a (2, 2) covariance."""
    (xx, xy), (_, yy) = covariance.tolist()
    return math.sqrt(0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy))


def _means(hypotheses: Sequence[Hypothesis]) -> tuple[FloatArray, FloatArray]:
    weights = np.array([hypothesis.weight for hypothesis in hypotheses])
    return weights, np.array([hypothesis.belief.gaussian.mean for hypothesis in hypotheses])


def _mean_the_same(hypotheses: Hypotheses) -> bool:
    weights, means = _means(hypotheses)
    places = means[:, POSITION]
    spread = float(weights @ ((places - weights @ places) ** 2).sum(axis=1))
    inner = sum(
        hypothesis.weight * float(hypothesis.belief.gaussian.covariance[POSITION, POSITION].trace())
        for hypothesis in hypotheses
    )
    return spread < SAME**2 * inner
