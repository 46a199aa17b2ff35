from __future__ import annotations

import math

import numpy as np
import pytest

from swarm_agent.localization.motion_model import BIAS, POSITION, VELOCITY, MotionModel, belief_at


def test_at_yaw_zero_it_is_the_model_of_the_thesis():
    dt, acceleration = 0.5, np.array([0.3, -0.2])
    step = MotionModel(dt, 0.01, 0.0).step(acceleration, 0.0)
    transition = np.array([[1, dt, 0, 0], [0, 1, 0, 0], [0, 0, 1, dt], [0, 0, 0, 1]])
    push = np.array([[dt**2 / 2, 0], [dt, 0], [0, dt**2 / 2], [0, dt]])
    assert np.array_equal(step.transition[:4, :4], transition)
    assert step.drive[:4] == pytest.approx(push @ acceleration)
    assert step.noise[:4, :4] == pytest.approx(1e-4 * push @ push.T)


def test_constant_acceleration_is_integrated_without_error():
    model, state = MotionModel(0.5, 0.01, 0.0), np.array([1.0, 0.2, -2.0, 0.0, 0.0, 0.0])
    for _ in range(20):
        step = model.step(np.array([0.1, -0.3]), 0.0)
        state = step.transition @ state + step.drive
    assert state[POSITION] == pytest.approx([1.0 + 0.2 * 10 + 0.05 * 100, -2.0 - 0.15 * 100])
    assert state[VELOCITY] == pytest.approx([0.2 + 1.0, -3.0])


def test_a_body_acceleration_is_turned_into_the_world_frame():
    step = MotionModel(0.5, 0.01, 0.0).step(np.array([1.0, 0.0]), math.pi / 2.0)
    assert step.drive[VELOCITY] == pytest.approx([0.0, 0.5])
    step = MotionModel(0.5, 0.01, 0.0).step(np.array([0.0, 1.0]), math.pi / 2.0)
    assert step.drive[VELOCITY] == pytest.approx([-0.5, 0.0])


def test_a_bias_acts_as_the_opposite_acceleration_at_every_heading():
    model, bias = MotionModel(0.5, 0.01, 0.0), np.array([3e-4, -5e-4])
    for yaw in np.linspace(-3.0, 3.0, 7):
        state = np.concatenate((np.zeros(4), bias))
        step = model.step(bias, yaw)
        assert step.transition @ state + step.drive == pytest.approx(state, abs=1e-18)


def test_a_doubtful_heading_makes_strong_accelerations_doubtful():
    model = MotionModel(0.5, 0.01, 0.02)
    calm, strong = (model.step(np.array([a, 0.0]), 0.0).noise[1, 1] for a in (0.0, 2.0))
    assert strong / calm == pytest.approx((0.01**2 + 0.04**2) / 0.01**2)


def test_the_first_belief_holds_what_is_known_of_a_robot_at_rest():
    belief = belief_at(np.array([3.0, 4.0]), 0.02**2 * np.eye(2), 0.1, 9.8e-4)
    assert belief.mean.tolist() == [3.0, 0.0, 4.0, 0.0, 0.0, 0.0]
    assert np.diag(belief.covariance)[POSITION] == pytest.approx(4e-4)
    assert np.diag(belief.covariance)[VELOCITY] == pytest.approx(1e-2)
    uniform = np.random.default_rng(0).uniform(-9.8e-4, 9.8e-4, 100_000)
    assert np.diag(belief.covariance)[BIAS] == pytest.approx(uniform.var(), rel=0.02)
