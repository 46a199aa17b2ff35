"""Laws of trilateration on random geometries: symmetry, order, bounded errors, finite answers."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from swarm_agent.localization.trilateration import Rejection, Trilateration, trilaterate

SEEDS = st.integers(0, 2**32 - 1)
COUNTS = st.integers(3, 9)
THICKNESS = st.sampled_from([0.0, 1e-9, 1e-3, 0.03, 0.1, 0.3, 1.0])
"""Of the cloud of beacons: on a line, or within a hair, or a round cloud."""


class Situation:
    """A robot, its belief, beacons in a cloud of some thickness, and noisy ranges."""

    def __init__(self, seed, count, thickness, sigma=1.0):
        rng = np.random.default_rng(seed)
        self.sigma = sigma
        self.robot = rng.uniform(-10.0, 10.0, 2)
        self.beacons = rng.uniform(-15.0, 15.0, (count, 2)) * (1.0, thickness)
        self.beacons = self.beacons @ rotation(rng.uniform(0.0, 7.0)).T + rng.uniform(-10.0, 10.0, 2)
        distances = np.hypot(*(self.beacons - self.robot).T)
        self.ranges = np.maximum(distances + rng.normal(0.0, sigma, count), 0.0)
        self.propagated = self.robot + rng.normal(0.0, 0.5, 2)
        self.covariance = 0.25 * np.eye(2)
        self.rng = rng

    def located(self):
        return trilaterate(self.beacons, self.ranges, self.propagated, self.covariance, self.sigma)


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def assert_same(one, other, turn=None, shift=0.0):
    """Check that two answers are the same but for rounding, after the first is turned and moved."""
    turn = np.eye(2) if turn is None else turn
    if isinstance(one, Rejection):
        assert one is other
        return
    assert isinstance(other, Trilateration)
    assert one.case is other.case
    np.testing.assert_allclose(one.position @ turn.T + shift, other.position, atol=1e-5)
    np.testing.assert_allclose(turn @ one.covariance @ turn.T, other.covariance, rtol=1e-5, atol=1e-5)


@given(seed=SEEDS, count=COUNTS, thickness=THICKNESS)
def test_a_turned_and_moved_world_has_the_turned_and_moved_answer(seed, count, thickness):
    here = Situation(seed, count, thickness)
    turn, shift = rotation(here.rng.uniform(-3.0, 3.0)), here.rng.uniform(-100.0, 100.0, 2)

    there = trilaterate(
        here.beacons @ turn.T + shift,
        here.ranges,
        here.propagated @ turn.T + shift,
        turn @ here.covariance @ turn.T,
        here.sigma,
    )

    assert_same(here.located(), there, turn, shift)


@given(seed=SEEDS, count=COUNTS, thickness=THICKNESS)
def test_the_order_of_the_beacons_does_not_matter(seed, count, thickness):
    here = Situation(seed, count, thickness)
    order = here.rng.permutation(count)

    shuffled = trilaterate(here.beacons[order], here.ranges[order], here.propagated, here.covariance, here.sigma)

    assert_same(here.located(), shuffled)


@given(seed=SEEDS, count=COUNTS, thickness=THICKNESS)
def test_ranges_without_noise_give_the_position_or_no_answer(seed, count, thickness):
    here = Situation(seed, count, thickness, sigma=0.0)

    fix = here.located()

    if isinstance(fix, Trilateration):
        # Close to the line of the beacons, rounding errors of the ranges are amplified, up to a thousandfold.
        np.testing.assert_allclose(fix.position, here.robot, atol=1e-6)
        assert not fix.covariance.any()


@given(seed=SEEDS, count=COUNTS, thickness=THICKNESS)
def test_no_geometry_turns_two_meters_of_noise_into_hundreds(seed, count, thickness):
    here = Situation(seed, count, thickness, sigma=2.0)

    fix = here.located()

    if isinstance(fix, Trilateration):
        assert np.hypot(*(fix.position - here.robot)) < 50.0


@given(seed=SEEDS, count=COUNTS)
def test_on_a_line_the_answer_stays_on_the_side_of_the_belief(seed, count):
    here = Situation(seed, count, 0.0)
    along = here.beacons[1] - here.beacons[0]
    normal = np.array([-along[1], along[0]]) / np.hypot(*along)

    fix = here.located()

    believed = normal @ (here.propagated - here.beacons[0])
    if isinstance(fix, Trilateration):
        assert abs(believed) > 1.5
        assert normal @ (fix.position - here.beacons[0]) * believed > 0.0
    elif abs(believed) < 1.5:
        assert fix is Rejection.MIRROR


@given(seed=SEEDS, count=COUNTS, thickness=THICKNESS)
def test_an_answer_fits_no_worse_than_the_true_position_on_average_and_never_absurdly(seed, count, thickness):
    here = Situation(seed, count, thickness)

    fix = here.located()

    if isinstance(fix, Trilateration):
        residuals = np.hypot(*(here.beacons - fix.position).T) - here.ranges
        assert np.sqrt(np.mean(residuals**2)) < 4.0 * here.sigma


FINITE = st.one_of(st.floats(-1e3, 1e3), st.floats(allow_nan=False, allow_infinity=False))
ANY = st.floats()


@given(data=st.data(), count=st.integers(0, 6), numbers=st.sampled_from([FINITE, ANY]))
def test_whatever_goes_in_an_answer_is_finite_and_its_covariance_positive(data, count, numbers):
    beacons, propagated = (
        data.draw(arrays(float, (count, 2), elements=numbers)),
        data.draw(arrays(float, 2, elements=numbers)),
    )
    ranges, covariance = (
        data.draw(arrays(float, count, elements=numbers)),
        data.draw(arrays(float, (2, 2), elements=numbers)),
    )

    fix = trilaterate(beacons, ranges, propagated, covariance, data.draw(st.floats(0.0, 1e300)))

    assert isinstance(fix, Trilateration | Rejection)
    assert (fix is Rejection.TOO_FEW) == (count < 3)
    if isinstance(fix, Trilateration):
        assert np.isfinite(fix.position).all()
        assert np.isfinite(fix.covariance).all()
        assert np.array_equal(fix.covariance, fix.covariance.T)
        assert (np.diag(fix.covariance) >= 0.0).all()


@given(seed=SEEDS)
def test_numbers_of_any_magnitude_overflow_into_a_refusal_not_into_an_exception(seed):
    rng = np.random.default_rng(seed)
    for _ in range(40):
        beacons, ranges, where, covariance, sigma = (
            rng.normal(size=shape) * 10.0 ** rng.choice([-300, -160, 0, 0, 0, 5, 80, 120, 155, 200, 300], size=shape)
            for shape in ((4, 2), 4, 2, (2, 2), ())
        )
        fix = trilaterate(beacons, ranges, where, covariance, abs(float(sigma)))
        if isinstance(fix, Trilateration):
            assert np.isfinite([*fix.position, *fix.covariance.flat, fix.squared_residual]).all()
