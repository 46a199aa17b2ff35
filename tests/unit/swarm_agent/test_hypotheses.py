"""Sums of Gaussians: splitting, weighing and joining beliefs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from swarm_agent.localization.hypotheses import (
    NARROWING,
    RING,
    WIDE_M,
    Hypothesis,
    certain,
    divided,
    merged,
    reweighed,
    widest,
)
from swarm_agent.localization.kalman import Gaussian
from swarm_agent.localization.motion_model import POSITION, STATES, belief_at
from swarm_agent.localization.range_fusion import SplitBelief
from swarm_msgs_py.randomness import rng_for

SCALE = np.array([4.0, 0.5, 4.0, 0.5, 1e-3, 1e-3])


def wide_belief(seed: int, shared: float = 0.0) -> SplitBelief:
    """Return a belief in which everything is correlated with everything, uncertain by some meters."""
    rng = rng_for(seed, "wide")
    root = rng.normal(size=(STATES, STATES)) * SCALE[:, None]
    return SplitBelief(Gaussian(rng.normal(size=STATES) * SCALE, root @ root.T + np.diag(SCALE**2)), shared)


def at(x: float, y: float, sigma: float = 1.0, shared: float = 0.0) -> SplitBelief:
    return SplitBelief(belief_at(np.array([x, y]), sigma**2 * np.eye(2), 0.1, 1e-3), shared)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), shared=st.sampled_from([0.0, 0.3, 0.6]))
def test_the_parts_have_together_the_moments_of_the_whole(seed: int, shared: float) -> None:
    belief = wide_belief(seed, shared)

    parts = divided(certain(belief))

    assert len(parts) == RING + 1
    assert sum(part.weight for part in parts) == pytest.approx(1.0)
    whole = merged(parts)
    assert_allclose(whole.gaussian.mean, belief.gaussian.mean, atol=1e-9)
    assert_allclose(whole.gaussian.covariance, belief.gaussian.covariance, atol=1e-6)
    assert whole.shared == pytest.approx(shared, abs=1e-6)


def test_each_part_is_a_covariance_narrower_than_the_whole() -> None:
    belief = wide_belief(1)

    for part in divided(certain(belief)):
        covariance = part.belief.gaussian.covariance
        assert np.linalg.eigvalsh(covariance).min() > 0.0
        assert_allclose(
            covariance[POSITION, POSITION], NARROWING**2 * belief.gaussian.covariance[POSITION, POSITION], rtol=1e-6
        )


def test_the_shared_part_of_the_error_is_not_divided() -> None:
    belief = at(0.0, 0.0, sigma=4.0, shared=0.75)

    parts = divided(certain(belief))

    places = np.array([part.belief.gaussian.mean[POSITION] for part in parts])
    assert_allclose(np.cov(places.T, bias=True), (1.0 - NARROWING**2) * 4.0 * np.eye(2), atol=1e-6)
    for part in parts:
        variance = np.trace(part.belief.gaussian.covariance[POSITION, POSITION])
        assert part.belief.shared * variance == pytest.approx(0.75 * 32.0, rel=1e-6)
    assert divided(certain(at(0.0, 0.0, sigma=4.0, shared=1.0)))[0].belief.shared == 1.0
    assert len(divided(certain(at(0.0, 0.0, sigma=4.0, shared=1.0)))) == 1


@pytest.mark.parametrize(
    ("sigma", "shared", "parts"),
    [(0.99 * WIDE_M, 0.0, 1), (1.01 * WIDE_M, 0.0, RING + 1), (1.9 * WIDE_M, 0.75, 1), (2.1 * WIDE_M, 0.75, RING + 1)],
)
def test_only_a_wide_own_error_is_divided(sigma: float, shared: float, parts: int) -> None:
    before = certain(at(1.0, 2.0, sigma, shared))

    after = divided(before)

    assert len(after) == parts
    assert (after is before) == (parts == 1)


def test_what_is_wide_in_one_direction_only_is_divided() -> None:
    long = SplitBelief(belief_at(np.zeros(2), np.diag([9.0, 0.01]), 0.1, 1e-3), 0.0)

    assert len(divided(certain(long))) == RING + 1


def test_several_beliefs_are_left_alone() -> None:
    two = (Hypothesis(0.4, at(0.0, 0.0, 9.0)), Hypothesis(0.6, at(50.0, 0.0, 9.0)))

    assert divided(two) is two


@pytest.mark.parametrize("scale", [2.0, 1e3])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8), (-0.8, 0.6)])
def test_a_place_that_is_exact_in_one_direction_is_divided_along_the_other(
    direction: tuple[float, float], scale: float
) -> None:
    line = np.array(direction)
    belief = SplitBelief(belief_at(np.zeros(2), scale**2 * np.outer(line, line), 0.1, 1e-3), 0.0)

    parts = divided(certain(belief))

    places = np.array([part.belief.gaussian.mean[POSITION] for part in parts])
    assert np.isfinite(places).all()
    across = np.array([-line[1], line[0]])
    assert_allclose(places @ across, 0.0, atol=1e-3 * scale)
    assert np.abs(places @ line).max() > 0.5 * scale


def test_weights_follow_bayes() -> None:
    far = tuple(Hypothesis(weight, at(20.0 * n, 0.0)) for n, weight in enumerate((0.2, 0.3, 0.5)))
    told = [(one, at(20.0 * n, 1.0), math.log(p)) for (n, one), p in zip(enumerate(far), (0.9, 0.3, 0.1), strict=True)]

    after = reweighed(told)

    joint = np.array([0.2 * 0.9, 0.3 * 0.3, 0.5 * 0.1])
    assert_allclose([one.weight for one in after], joint / joint.sum())
    assert [one.belief.gaussian.mean[2] for one in after] == [1.0, 1.0, 1.0]  # the beliefs after, not before


def test_likelihoods_that_are_all_far_too_small_to_be_numbers_are_compared_all_the_same() -> None:
    told = [(Hypothesis(0.5, at(20.0 * n, 0.0)), at(20.0 * n, 0.0), -1e5 - n) for n in range(2)]

    after = reweighed(told)

    assert [one.weight for one in after] == pytest.approx([1.0 / (1.0 + math.exp(-1.0)), 1.0 / (1.0 + math.e)])


def test_what_has_become_improbable_is_dropped_and_the_rest_sums_to_one() -> None:
    logs = (0.0, -1.0, -7.5)
    told = [(Hypothesis(1 / 3, at(20.0 * n, 0.0)), at(20.0 * n, 0.0), log) for n, log in enumerate(logs)]

    after = reweighed(told)

    assert [one.belief.gaussian.mean[0] for one in after] == [0.0, 20.0]
    assert sum(one.weight for one in after) == pytest.approx(1.0)


def test_beliefs_that_mean_the_same_place_become_one() -> None:
    near = [(Hypothesis(0.5, at(0.4 * n, 0.0)), at(0.4 * n, 0.0), 0.0) for n in range(2)]
    far = [(Hypothesis(0.5, at(4.0 * n, 0.0)), at(4.0 * n, 0.0), 0.0) for n in range(2)]

    (one,) = reweighed(near)

    assert one.weight == 1.0
    assert_allclose(one.belief.gaussian.mean[POSITION], [0.2, 0.0])
    assert_allclose(one.belief.gaussian.covariance[POSITION, POSITION], np.diag([1.04, 1.0]))
    assert len(reweighed(far)) == 2


def test_a_belief_without_alternative_needs_no_weighing() -> None:
    before, after = at(0.0, 0.0), at(1.0, 0.0)

    (one,) = reweighed([(Hypothesis(1.0, before), after, -1e9)])

    assert (one.weight, one.belief) == (1.0, after)


def test_the_merged_moments_are_those_of_the_mixture() -> None:
    rng = rng_for(3, "mixture")
    parts = [wide_belief(n, shared=0.2 * n) for n in range(3)]
    weights = (0.5, 0.3, 0.2)
    whole = merged(tuple(Hypothesis(w, part) for w, part in zip(weights, parts, strict=True)))

    drawn = np.concatenate([
        rng.multivariate_normal(part.gaussian.mean, part.gaussian.covariance, int(200_000 * w))
        for w, part in zip(weights, parts, strict=True)
    ])  # fmt: skip

    assert_allclose(whole.gaussian.mean / SCALE, drawn.mean(axis=0) / SCALE, atol=0.05)
    assert_allclose(
        whole.gaussian.covariance / np.outer(SCALE, SCALE), np.cov(drawn.T) / np.outer(SCALE, SCALE), atol=0.3
    )
    inner = sum(
        w * part.shared * np.trace(part.gaussian.covariance[POSITION, POSITION])
        for w, part in zip(weights, parts, strict=True)
    )
    assert whole.shared == pytest.approx(inner / np.trace(whole.gaussian.covariance[POSITION, POSITION]))


def test_the_widest_direction_is_the_root_of_the_largest_eigenvalue() -> None:
    for seed in range(5):
        root = rng_for(seed, "axes").normal(size=(2, 2))
        assert widest(root @ root.T) == pytest.approx(float(np.linalg.norm(root, 2)))
