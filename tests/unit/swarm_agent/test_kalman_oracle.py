"""The robot's filter against Stone Soup and filterpy: the same sequences, the same means and covariances.

The oracles are told the models as matrices and do all the filtering themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from stonesoup.base import Property
from stonesoup.models.control.linear import LinearControlModel
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.measurement.nonlinear import NonLinearGaussianMeasurement
from stonesoup.models.transition.linear import LinearGaussianTimeInvariantTransitionModel
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.types.array import StateVector, StateVectors
from stonesoup.types.detection import Detection
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.state import GaussianState, State
from stonesoup.updater.kalman import ExtendedKalmanUpdater, KalmanUpdater

from swarm_agent.localization.kalman import Gaussian, correct, innovation, predict
from swarm_agent.localization.motion_model import OBSERVE_POSITION, POSITION, STATES, MotionModel, Step
from swarm_msgs_py.types import FloatArray

TICKS, DT = 200, 0.5
EPOCH = datetime(2000, 1, 1)  # Stone Soup wants a date; only differences count
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Tick:
    """What happens in one period: a step of the motion, and where a measurement says that the robot is."""

    number: int
    step: Step
    noise: FloatArray
    position: FloatArray


class RangesToBeacons(NonLinearGaussianMeasurement):
    """Distances to known points, as Stone Soup takes a nonlinear measurement."""

    beacons: np.ndarray = Property(doc="Positions, (m, 2)")

    @property
    def ndim_meas(self) -> int:
        return len(self.beacons)

    def function(self, state: State, noise: bool = False, **_: object) -> StateVectors:
        assert not noise
        offsets = np.asarray(state.state_vector, dtype=float)[POSITION][:, None] - self.beacons.T[:, :, None]
        return np.hypot(*offsets).view(StateVectors)

    def jacobian(self, state: State, **_: object) -> FloatArray:
        # Stone Soup would take differences, good for seven digits: a test below compares the two.
        rows = np.zeros((self.ndim_meas, STATES))
        for row, beacon in zip(rows, self.beacons, strict=True):
            offset = np.asarray(state.state_vector, dtype=float)[POSITION, 0] - beacon
            row[POSITION] = offset / np.linalg.norm(offset)
        return rows


def random_belief(rng: np.random.Generator) -> Gaussian:
    mean = np.concatenate((rng.normal(0.0, 5.0, 4), rng.normal(0.0, 5e-4, 2)))
    scale = np.diag([2.0, 0.3, 2.0, 0.3, 5e-4, 5e-4])
    factor = rng.normal(size=(STATES, STATES)) + 2.0 * np.eye(STATES)
    return Gaussian(mean, scale @ factor @ factor.T @ scale)


def story(rng: np.random.Generator) -> Iterator[Tick]:
    """Yield the periods of a robot that drives about at random."""
    model = MotionModel(DT, 0.01, 0.01, 0.12, 0.03)
    for number in range(1, TICKS + 1):
        step = model.step(rng.normal(0.0, 0.3, 2), rng.uniform(-3.0, 3.0))
        factor = rng.normal(size=(2, 2)) + np.eye(2)
        yield Tick(number, step, factor @ factor.T + 0.1 * np.eye(2), rng.normal(0.0, 5.0, 2))


def predicted_by_stone_soup(state: GaussianState, tick: Tick) -> GaussianState:
    motion = LinearGaussianTimeInvariantTransitionModel(
        transition_matrix=tick.step.transition, covariance_matrix=tick.step.noise
    )
    push = LinearControlModel(control_matrix=tick.step.drive[:, None])
    time = EPOCH + timedelta(seconds=DT * tick.number)
    return KalmanPredictor(motion, push).predict(state, timestamp=time, control_input=State(StateVector([1.0])))


def corrected_by_stone_soup(updater: KalmanUpdater, state: GaussianState, reading: FloatArray) -> GaussianState:
    detection = Detection(StateVector(reading), state.timestamp, updater.measurement_model)
    return updater.update(SingleHypothesis(state, detection))


def stone_soup_state(belief: Gaussian) -> GaussianState:
    return GaussianState(StateVector(belief.mean), belief.covariance.copy(), EPOCH)


def assert_same(belief: Gaussian, state: GaussianState) -> None:
    np.testing.assert_allclose(belief.mean, np.asarray(state.mean, dtype=float)[:, 0], rtol=TOLERANCE, atol=TOLERANCE)
    np.testing.assert_allclose(belief.covariance, np.asarray(state.covar), rtol=TOLERANCE, atol=TOLERANCE)


@pytest.mark.parametrize("every", [1, 6, TICKS + 1])
@pytest.mark.parametrize("use_joseph", [False, True])
def test_dead_reckoning_and_position_fixes_agree_with_stone_soup(every: int, use_joseph: bool) -> None:
    rng = np.random.default_rng(every)
    belief = random_belief(rng)
    state = stone_soup_state(belief)
    for tick in story(rng):
        belief = predict(belief, tick.step.transition, tick.step.drive, tick.step.noise)
        state = predicted_by_stone_soup(state, tick)
        assert_same(belief, state)
        if tick.number % every == 0:
            residual = tick.position - belief.mean[POSITION]
            surprise = innovation(belief, residual, OBSERVE_POSITION, tick.noise)
            belief = correct(belief, surprise, OBSERVE_POSITION, tick.noise)
            fix = LinearGaussian(STATES, (0, 2), tick.noise)
            state = corrected_by_stone_soup(KalmanUpdater(fix, use_joseph_cov=use_joseph), state, tick.position)
            assert_same(belief, state)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_an_extended_filter_on_ranges_agrees_with_stone_soup_and_filterpy(count: int) -> None:
    rng = np.random.default_rng(count)
    belief = random_belief(rng)
    state = stone_soup_state(belief)
    other = ExtendedKalmanFilter(dim_x=STATES, dim_z=count)
    other.x, other.P = belief.mean[:, None].copy(), belief.covariance.copy()
    for tick in story(rng):
        beacons = rng.uniform(-20.0, 20.0, (count, 2))
        noise = np.diag(rng.uniform(0.5, 4.0, count))
        ranges = np.hypot(*(beacons - tick.position).T) + rng.normal(0.0, 1.0, count)
        model = RangesToBeacons(ndim_state=STATES, mapping=(0, 2), noise_covar=noise, beacons=beacons)

        belief = predict(belief, tick.step.transition, tick.step.drive, tick.step.noise)
        offsets = belief.mean[POSITION] - beacons
        distances = np.hypot(*offsets.T)
        observation = (offsets / distances[:, None]) @ OBSERVE_POSITION
        surprise = innovation(belief, ranges - distances, observation, noise)
        belief = correct(belief, surprise, observation, noise)

        state = predicted_by_stone_soup(state, tick)
        state = corrected_by_stone_soup(ExtendedKalmanUpdater(model), state, ranges)
        assert_same(belief, state)

        other.F, other.B, other.Q = tick.step.transition, tick.step.drive[:, None], tick.step.noise
        other.predict(u=np.ones((1, 1)))
        other.update(
            ranges[:, None],
            lambda x, model=model: model.jacobian(State(x)),
            lambda x, model=model: model.function(State(x)),
            R=noise,
        )
        np.testing.assert_allclose(belief.mean, other.x[:, 0], rtol=TOLERANCE, atol=TOLERANCE)
        np.testing.assert_allclose(belief.covariance, other.P, rtol=TOLERANCE, atol=TOLERANCE)
        assert surprise.squared == pytest.approx(other.mahalanobis**2, rel=1e-8)


def test_the_jacobian_that_the_oracles_are_given_is_the_one_of_their_measurement() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        beacons, state = rng.uniform(-20.0, 20.0, (3, 2)), State(StateVector(rng.normal(0.0, 5.0, STATES)))
        model = RangesToBeacons(ndim_state=STATES, mapping=(0, 2), noise_covar=np.eye(3), beacons=beacons)
        by_differences = super(RangesToBeacons, model).jacobian(state)
        np.testing.assert_allclose(model.jacobian(state), by_differences, atol=1e-6)
