from __future__ import annotations

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from swarm_agent.localization.kalman import Gaussian, correct, innovation, predict

STATES = 4


def random_covariance(rng: np.random.Generator, size: int) -> np.ndarray:
    factor = rng.normal(size=(size, size))
    return factor @ factor.T + 0.1 * np.eye(size)


@pytest.mark.parametrize("measured", [1, 2, 3])
def test_it_agrees_with_filterpy_over_a_long_random_run(measured):
    rng = np.random.default_rng(measured)
    oracle = KalmanFilter(dim_x=STATES, dim_z=measured)
    belief = Gaussian(rng.normal(size=STATES), random_covariance(rng, STATES))
    oracle.x, oracle.P = belief.mean[:, None].copy(), belief.covariance.copy()
    for _ in range(50):
        transition = np.eye(STATES) + 0.1 * rng.normal(size=(STATES, STATES))
        drive, noise = rng.normal(size=STATES), random_covariance(rng, STATES)
        observation, measurement_noise = rng.normal(size=(measured, STATES)), random_covariance(rng, measured)
        reading = rng.normal(size=measured)
        belief = predict(belief, transition, drive, noise)
        oracle.predict(u=drive[:, None], B=np.eye(STATES), F=transition, Q=noise)
        surprise = innovation(belief, reading - observation @ belief.mean, observation, measurement_noise)
        belief = correct(belief, surprise, observation, measurement_noise)
        oracle.update(reading[:, None], R=measurement_noise, H=observation)
        assert belief.mean == pytest.approx(oracle.x[:, 0], rel=1e-8, abs=1e-10)
        assert belief.covariance == pytest.approx(oracle.P, rel=1e-8, abs=1e-10)
        assert surprise.squared == pytest.approx(oracle.mahalanobis**2, rel=1e-8)


def test_the_covariance_stays_symmetric_and_positive_under_extreme_precision():
    belief = Gaussian(np.zeros(2), np.diag([1e6, 1e6]))
    observation, noise = np.array([[1.0, 0.0]]), np.array([[1e-10]])
    transition = np.array([[1.0, 0.5], [0.0, 1.0]])
    for _ in range(500):
        belief = predict(belief, transition, np.zeros(2), np.zeros((2, 2)))
        surprise = innovation(belief, np.zeros(1), observation, noise)
        belief = correct(belief, surprise, observation, noise)
        assert np.array_equal(belief.covariance, belief.covariance.T)
        assert np.linalg.eigvalsh(belief.covariance).min() > -1e-18


def test_a_measurement_never_makes_the_belief_less_certain():
    rng = np.random.default_rng(7)
    belief = Gaussian(np.zeros(STATES), random_covariance(rng, STATES))
    observation, noise = rng.normal(size=(2, STATES)), random_covariance(rng, 2)
    after = correct(belief, innovation(belief, np.ones(2), observation, noise), observation, noise)
    assert np.linalg.eigvalsh(belief.covariance - after.covariance).min() > -1e-12


def test_the_inputs_are_left_as_they_were():
    belief = Gaussian(np.ones(2), np.eye(2))
    surprise = innovation(belief, np.ones(2), np.eye(2), np.eye(2))
    correct(predict(belief, np.eye(2), np.ones(2), np.eye(2)), surprise, np.eye(2), np.eye(2))
    assert belief.mean.tolist() == [1.0, 1.0]
    assert belief.covariance.tolist() == np.eye(2).tolist()
