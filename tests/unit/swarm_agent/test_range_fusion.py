"""Fusion of ranges against textbook filters, its own promises, and the best that any estimator could do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from swarm_agent.localization.kalman import Gaussian
from swarm_agent.localization.motion_model import POSITION, STATES, belief_at
from swarm_agent.localization.observations import RangeObservations
from swarm_agent.localization.range_fusion import (
    RangeModel,
    SplitBelief,
    fixed,
    fuse_beacons,
    fuse_neighbors,
    predicted,
)
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray

MODEL = RangeModel(sigma=2.0, gate=10.8, inflation=3.0)
OPEN = replace(MODEL, gate=1e9)  # takes everything
XX_XY_YY = (0, 0, 1), (0, 1, 1)


def random_belief(rng: np.random.Generator, scale: float = 1.0, shared: float = 0.0) -> SplitBelief:
    """Return a belief in which everything is correlated with everything."""
    root = rng.normal(size=(STATES, STATES)) * np.array([1.0, 0.2, 1.0, 0.2, 1e-3, 1e-3])[:, None] * scale
    return SplitBelief(Gaussian(rng.normal(size=STATES), root @ root.T), shared)


def seen_from(
    origin: FloatArray, rng: np.random.Generator, count: int, sigma: float = 1.0, shared: float | None = None
) -> RangeObservations:
    """Return ranges, good to 1 m, to neighbors within 20 m."""
    roots = sigma * rng.normal(size=(count, 2, 2))
    covariances = roots @ roots.transpose(0, 2, 1)
    positions = origin + rng.uniform(-20.0, 20.0, (count, 2))
    shares = rng.uniform(0.0, 1.0, count) if shared is None else np.full(count, shared)
    ranges = np.linalg.norm(positions - origin, axis=1) + rng.normal(size=count)
    return RangeObservations(positions, covariances[:, *XX_XY_YY], shares, ranges)


def one(
    position: tuple[float, float], distance: float, variance: float = 0.0, shared: float = 0.0
) -> RangeObservations:
    return RangeObservations(
        np.array([position]), np.array([[variance, 0.0, variance]]), np.array([shared]), np.array([distance])
    )


def trace(belief: SplitBelief) -> float:
    return float(np.trace(belief.gaussian.covariance[POSITION, POSITION]))


def test_one_range_to_a_far_beacon_is_the_update_of_an_extended_kalman_filter() -> None:
    belief = random_belief(rng_for(1, "ekf"))
    mean, covariance = belief.gaussian.mean, belief.gaussian.covariance
    beacon = np.array([4e5, 3e5])  # so far that circles are lines
    offset = mean[POSITION] - beacon
    predicted_range = float(np.linalg.norm(offset))
    row = np.zeros((1, STATES))
    row[0, POSITION] = offset / predicted_range
    gain = covariance @ row.T / (row @ covariance @ row.T + MODEL.sigma**2)

    after = fuse_beacons(belief, one((4e5, 3e5), predicted_range + 1.5), MODEL).belief.gaussian

    assert_allclose(after.mean, mean + 1.5 * gain[:, 0], atol=1e-4)
    assert_allclose(after.covariance, covariance - gain @ row @ covariance, rtol=1e-6, atol=1e-9)


def test_many_ranges_at_once_are_the_batch_update_of_a_kalman_filter() -> None:
    rng = rng_for(2, "batch")
    belief = random_belief(rng)
    mean, covariance = belief.gaussian.mean, belief.gaussian.covariance
    seen = seen_from(mean[POSITION], rng, 7, sigma=0.0)
    seen = replace(seen, positions=1e4 * seen.positions)
    offsets = mean[POSITION] - seen.positions
    distances = np.linalg.norm(offsets, axis=1)
    seen = replace(seen, ranges=distances + rng.normal(size=7))
    rows = np.zeros((7, STATES))
    rows[:, POSITION] = offsets / distances[:, None]
    gain = covariance @ rows.T @ np.linalg.inv(rows @ covariance @ rows.T + MODEL.sigma**2 * np.eye(7))

    after = fuse_beacons(belief, seen, OPEN).belief.gaussian

    assert_allclose(after.mean, mean + gain @ (seen.ranges - distances), atol=1e-4)
    assert_allclose(after.covariance, covariance - gain @ rows @ covariance, rtol=1e-5, atol=1e-8)


def test_an_uncertain_beacon_counts_less_than_a_certain_one() -> None:
    belief = SplitBelief(belief_at(np.zeros(2), 4.0 * np.eye(2), 0.1, 1e-3), 0.0)

    sure, vague = (fuse_beacons(belief, one((20.0, 0.0), 19.0, v), MODEL).belief for v in (0.0, 4.0))

    assert trace(sure) < trace(vague) < trace(belief)
    assert sure.gaussian.mean[0] > vague.gaussian.mean[0] > 0.0


def test_neighbors_without_errors_are_beacons() -> None:
    rng = rng_for(3, "exact")
    belief = random_belief(rng)
    seen = seen_from(belief.gaussian.mean[POSITION], rng, 5, sigma=0.0, shared=0.0)

    by_beacons, by_neighbors = fuse_beacons(belief, seen, OPEN).belief, fuse_neighbors(belief, seen, OPEN).belief

    assert_allclose(by_neighbors.gaussian.mean, by_beacons.gaussian.mean)
    assert_allclose(by_neighbors.gaussian.covariance, by_beacons.gaussian.covariance)
    assert by_neighbors.shared == 0.0


FUSERS = pytest.mark.parametrize("fuse", [fuse_beacons, fuse_neighbors])


@FUSERS
@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(1, 12),
    own=st.sampled_from([0.0, 1e-6, 1e-2, 1.0, 60.0]),
    their=st.sampled_from([0.0, 1e-4, 1.0, 30.0]),
    sigma=st.sampled_from([1e-4, 0.1, 2.0]),
    shared=st.sampled_from([0.0, 0.3, 1.0]),
)
def test_whatever_is_fused_stays_a_covariance_that_did_not_grow(  # type: ignore[no-untyped-def]
    fuse, seed: int, count: int, own: float, their: float, sigma: float, shared: float
) -> None:
    rng = rng_for(seed, "psd")
    belief = random_belief(rng, own, shared)
    seen = seen_from(belief.gaussian.mean[POSITION], rng, count, their)

    fusion = fuse(belief, seen, replace(MODEL, sigma=sigma, gate=float(rng.choice([10.8, 1e12]))))

    prior, after = belief.gaussian.covariance, fusion.belief.gaussian.covariance
    size = max(float(prior.max()), 1e-12)
    assert np.isfinite(fusion.belief.gaussian.mean).all()
    assert_allclose(after, after.T, rtol=0.0, atol=1e-12 * size)
    assert np.linalg.eigvalsh(after).min() >= -1e-12 * size
    assert np.linalg.eigvalsh(prior - after).min() >= -1e-9 * size
    assert 0.0 <= fusion.belief.shared <= 1.0
    assert fusion.accepted + fusion.rejected == count


@FUSERS
def test_the_order_of_the_neighbors_does_not_matter(fuse) -> None:  # type: ignore[no-untyped-def]
    rng = rng_for(4, "order")
    belief = random_belief(rng, shared=0.3)
    seen = seen_from(belief.gaussian.mean[POSITION], rng, 9)
    order = rng.permutation(9)
    shuffled = RangeObservations(seen.positions[order], seen.covariances[order], seen.shared[order], seen.ranges[order])

    one_way, other_way = fuse(belief, seen, MODEL).belief, fuse(belief, shuffled, MODEL).belief

    assert_allclose(one_way.gaussian.mean, other_way.gaussian.mean, rtol=1e-12, atol=1e-12)
    assert_allclose(one_way.gaussian.covariance, other_way.gaussian.covariance, rtol=1e-12, atol=1e-15)
    assert one_way.shared == pytest.approx(other_way.shared)


@FUSERS
def test_nothing_seen_changes_nothing(fuse) -> None:  # type: ignore[no-untyped-def]
    belief = random_belief(rng_for(5))
    nothing = RangeObservations(np.empty((0, 2)), np.empty((0, 3)), np.empty(0), np.empty(0))

    fusion = fuse(belief, nothing, MODEL)

    assert fusion.belief is belief
    assert (fusion.accepted, fusion.rejected) == (0, 0)


@FUSERS
def test_an_outlier_is_counted_and_has_no_influence(fuse) -> None:  # type: ignore[no-untyped-def]
    belief = SplitBelief(belief_at(np.zeros(2), np.eye(2), 0.1, 1e-3), 0.2)
    good = one((20.0, 0.0), 20.5)
    wild = one((0.0, 20.0), 45.0)
    both = RangeObservations(
        *(np.concatenate(pair) for pair in (
            (good.positions, wild.positions),
            (good.covariances, wild.covariances),
            (good.shared, wild.shared),
            (good.ranges, wild.ranges),
        ))
    )  # fmt: skip

    alone, with_outlier, only_outlier = (fuse(belief, seen, MODEL) for seen in (good, both, wild))

    assert (with_outlier.accepted, with_outlier.rejected) == (1, 1)
    assert_allclose(with_outlier.belief.gaussian.mean, alone.belief.gaussian.mean)
    assert_allclose(with_outlier.belief.gaussian.covariance, alone.belief.gaussian.covariance)
    assert (only_outlier.accepted, only_outlier.rejected) == (0, 1)
    assert_allclose(only_outlier.belief.gaussian.mean, belief.gaussian.mean)
    assert_allclose(only_outlier.belief.gaussian.covariance, belief.gaussian.covariance, atol=1e-15)
    assert only_outlier.belief.shared == pytest.approx(belief.shared)


@FUSERS
@pytest.mark.parametrize(("surprise", "is_taken"), [(0.99, True), (1.01, False), (-0.99, True), (-1.01, False)])
def test_the_gate_is_the_normalized_innovation_squared(fuse, surprise: float, is_taken: bool) -> None:  # type: ignore[no-untyped-def]
    belief = SplitBelief(belief_at(np.zeros(2), np.diag([5.0, 0.0]), 0.1, 1e-3), 0.0)
    limit = np.sqrt(MODEL.gate * (MODEL.sigma**2 + 5.0))

    fusion = fuse(belief, one((100.0, 0.0), 100.0 + surprise * limit), MODEL)

    assert (fusion.accepted, fusion.rejected) == ((1, 0) if is_taken else (0, 1))


@FUSERS
def test_a_neighbor_in_the_same_place_says_nothing_about_the_direction(fuse) -> None:  # type: ignore[no-untyped-def]
    belief = SplitBelief(belief_at(np.array([3.0, 4.0]), np.eye(2), 0.1, 1e-3), 0.5)

    fusion = fuse(belief, one((3.0, 4.0), 1.0, 0.3), MODEL)

    assert_allclose(fusion.belief.gaussian.mean, belief.gaussian.mean)
    assert_allclose(fusion.belief.gaussian.covariance, belief.gaussian.covariance)


def test_errors_across_the_line_make_ranges_longer_and_a_fit_expects_that() -> None:
    """The mean of many ranges from places that scatter as the belief says moves a filter nowhere."""
    rng, beacon = rng_for(6, "curvature"), np.array([3.0, 0.0])
    belief = SplitBelief(belief_at(np.zeros(2), np.diag([1e-6, 1.0]), 0.0, 0.0), 0.0)
    scattered = rng.normal(size=(20_000, 2)) * [1e-3, 1.0]
    mean_range = float(np.linalg.norm(scattered - beacon, axis=1).mean())
    assert mean_range > 3.1  # so a filter that only linearizes would step back by a tenth of a meter

    sharp = replace(OPEN, sigma=1e-2)
    unsure = SplitBelief(belief_at(np.zeros(2), np.eye(2), 0.0, 0.0), 0.0)

    assert fuse_beacons(belief, one((3.0, 0.0), mean_range), sharp).belief.gaussian.mean[0] == pytest.approx(
        0, abs=2e-6
    )
    after = fuse_beacons(unsure, one((3.0, 0.0), mean_range), sharp).belief.gaussian
    assert abs(after.mean[0]) < 0.03  # linearized: 0.16
    assert after.covariance[0, 0] > 0.04  # what one such range is good for, however sharp: (0.5 / 3^2)


def test_with_an_error_that_all_share_a_range_to_a_neighbor_changes_nothing() -> None:
    rng = rng_for(7, "all shared")
    belief = random_belief(rng, shared=1.0)
    seen = seen_from(belief.gaussian.mean[POSITION], rng, 6, shared=1.0)
    worse = belief.gaussian.covariance[POSITION, POSITION][XX_XY_YY] + np.array([0.5, 0.0, 0.5])
    seen = replace(seen, covariances=np.tile(worse, (6, 1)))

    fusion = fuse_neighbors(belief, seen, MODEL)

    assert fusion.accepted > 0
    assert_allclose(fusion.belief.gaussian.mean, belief.gaussian.mean, atol=1e-12)
    assert_allclose(fusion.belief.gaussian.covariance, belief.gaussian.covariance, atol=1e-12)
    assert fusion.belief.shared == pytest.approx(1.0)


def test_what_is_taken_over_from_neighbors_is_shared_from_then_on() -> None:
    belief = SplitBelief(belief_at(np.zeros(2), 4.0 * np.eye(2), 0.1, 1e-3), 0.0)

    shares, variances = [], [trace(belief)]
    for _ in range(5):
        belief = fuse_neighbors(belief, one((20.0, 0.0), 20.0, 1.0), OPEN).belief
        shares.append(belief.shared)
        variances.append(trace(belief))

    assert shares == sorted(shares)
    assert shares[0] > 0.0
    assert variances == sorted(variances, reverse=True)


def test_beacons_reduce_the_shared_error_as_well() -> None:
    belief = SplitBelief(belief_at(np.zeros(2), 4.0 * np.eye(2), 0.1, 1e-3), 0.8)
    seen = RangeObservations(
        np.array([[30.0, 0.0], [0.0, 30.0], [-30.0, 0.0], [0.0, -30.0]]),
        np.zeros((4, 3)), np.zeros(4), np.full(4, 30.0),
    )  # fmt: skip

    after = fuse_beacons(belief, seen, MODEL).belief

    assert after.shared * trace(after) < 0.5 * belief.shared * trace(belief)
    assert after.shared == pytest.approx(belief.shared * trace(after) / trace(belief), rel=0.05)  # isotropic: k^2 of P


def test_noise_of_the_own_motion_is_the_own_error() -> None:
    belief = SplitBelief(belief_at(np.zeros(2), np.eye(2), 0.1, 1e-3), 0.6)
    noise = np.diag([0.5, 0.0, 0.5, 0.0, 0.0, 0.0])
    ahead = replace(belief.gaussian, covariance=belief.gaussian.covariance + noise)

    after = predicted(belief, ahead, noise)

    assert after.shared * trace(after) == pytest.approx(0.6 * trace(belief))


def test_bookkeeping_survives_a_belief_without_any_variance() -> None:
    exact = SplitBelief(Gaussian(np.zeros(STATES), np.zeros((STATES, STATES))), 0.5)

    for after in (
        fixed(exact, exact.gaussian),
        predicted(exact, exact.gaussian, np.zeros((STATES, STATES))),
        fuse_beacons(exact, one((5.0, 0.0), 7.0), OPEN).belief,
        fuse_neighbors(exact, one((5.0, 0.0), 7.0, 1.0, 0.5), OPEN).belief,
        fuse_neighbors(exact, one((5.0, 0.0), 7.0), OPEN).belief,
    ):
        assert_allclose(after.gaussian.mean, 0.0)
        assert_allclose(after.gaussian.covariance, 0.0)
        assert 0.0 <= after.shared <= 1.0


# A problem small enough to be solved jointly: robots at rest on a ring, no beacon, everybody ranges to everybody.

PRIOR_SIGMA, RANGE_SIGMA = 1.0, 0.5


def ring(robots: int) -> FloatArray:
    angles = np.arange(robots) * 2.0 * np.pi / robots
    return 20.0 * np.column_stack([np.cos(angles), np.sin(angles)])


def joint_optimum(points: FloatArray, rounds: int) -> float:
    """Return the mean trace of the covariance that an estimator has which knows all ranges and correlations [m^2]."""
    count = len(points)
    information = np.eye(2 * count) / PRIOR_SIGMA**2
    for i in range(count):
        for j in set(range(count)) - {i}:
            row = np.zeros((count, 2))
            row[i] = (points[i] - points[j]) / np.linalg.norm(points[i] - points[j])
            row[j] = -row[i]
            information += rounds * np.outer(row, row) / RANGE_SIGMA**2
    return float(np.trace(np.linalg.inv(information))) / count


def cooperate(points: FloatArray, rounds: int, *, naive: bool) -> list[SplitBelief]:
    """Return the beliefs after rounds of ranging; the naive filter takes neighbors for beacons."""
    rng, count = rng_for(8, "ring", len(points)), len(points)
    fuse, model = (fuse_beacons if naive else fuse_neighbors), replace(OPEN, sigma=RANGE_SIGMA)
    beliefs = [
        SplitBelief(belief_at(point + PRIOR_SIGMA * rng.normal(size=2), PRIOR_SIGMA**2 * np.eye(2), 0.0, 0.0), 0.0)
        for point in points
    ]
    for _ in range(rounds):
        means = np.array([belief.gaussian.mean[POSITION] for belief in beliefs])
        covariances = np.array([belief.gaussian.covariance[POSITION, POSITION][XX_XY_YY] for belief in beliefs])
        shared = np.array([belief.shared for belief in beliefs])
        after = []
        for robot, belief in enumerate(beliefs):
            others = np.arange(count) != robot
            ranges = np.linalg.norm(points[others] - points[robot], axis=1) + RANGE_SIGMA * rng.normal(size=count - 1)
            seen = RangeObservations(means[others], covariances[others], shared[others], ranges)
            after.append(fuse(belief, seen, model).belief)
        beliefs = after
    return beliefs


@pytest.mark.parametrize(
    ("robots", "least"),
    [(2, 0.65), (3, 0.70), (5, 1.0), (8, 1.0)],  # of the optimum; a pair and a trio share in one direction only
)
def test_without_beacons_no_claim_undercuts_the_joint_optimum_by_more_than_a_known_factor(
    robots: int, least: float
) -> None:
    points = ring(robots)
    for rounds in (3, 30, 100):
        claims = [trace(belief) for belief in cooperate(points, rounds, naive=False)]
        assert min(claims) > least * joint_optimum(points, rounds)


def test_a_filter_that_takes_neighbors_for_beacons_is_a_hundred_times_too_sure() -> None:
    points = ring(5)
    claims = [trace(belief) for belief in cooperate(points, 100, naive=True)]
    errors = [
        np.sum((belief.gaussian.mean[POSITION] - point) ** 2)
        for belief, point in zip(cooperate(points, 100, naive=True), points, strict=True)
    ]

    assert max(claims) < 0.01 * joint_optimum(points, 100)
    assert np.mean(errors) > 10.0 * np.mean(claims)


@pytest.mark.parametrize(("mine", "theirs"), [(1.0, 1.0), (4.0, 1.0), (0.5, 2.0)])
def test_what_two_robots_have_in_common_after_they_ranged_to_each_other_counts_as_shared(
    mine: float, theirs: float
) -> None:
    """Two errors that were independent: e_i <- e_i + g_i (e_j - e_i + noise), and the other way around."""
    belief = SplitBelief(belief_at(np.zeros(2), np.diag([mine, mine]), 0.1, 0.0), 0.0)
    distance = 1e4  # so far that circles are lines

    after = fuse_neighbors(belief, one((distance, 0.0), distance, variance=theirs), OPEN).belief

    noise = MODEL.sigma**2
    gain = mine / (mine + MODEL.inflation * theirs + noise)
    their_gain = theirs / (theirs + MODEL.inflation * mine + noise)
    covariance = (1.0 - gain) * their_gain * mine + gain * (1.0 - their_gain) * theirs
    shared = after.shared * float(after.gaussian.covariance[0, 0])
    assert covariance <= shared <= 2.5 * covariance
