from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_sim.config import OmniConfig
from swarm_sim.firmware.omni_wheels import (
    WHEEL_BEARINGS,
    WHEEL_TANGENTS,
    StepMotors,
    WheelSlip,
    apply,
    mixing_matrices,
    unmixing_matrices,
)

STEP_S = 1.0 / 60.0
LEVER = np.array([0.08])


def rims(forward: float, left: float, turn: float = 0.0) -> np.ndarray:
    return apply(mixing_matrices(LEVER), np.array([[forward, left, turn]]))[0]


@pytest.mark.parametrize("alpha_deg", [0.0, 30.0, 90.0, 137.0, 260.0])
def test_rim_speeds_are_those_of_the_thesis(alpha_deg: float) -> None:
    speed, alpha = 0.05, np.deg2rad(alpha_deg)  # alpha clockwise from the front, so left is -sin
    thesis = [speed * np.cos(np.deg2rad(angle - alpha_deg)) for angle in (150.0, 30.0, 270.0)]

    assert_allclose(rims(speed * np.cos(alpha), -speed * np.sin(alpha)), thesis, atol=1e-12)


def test_wheels_roll_along_the_clockwise_tangent_of_their_place() -> None:
    assert_allclose((WHEEL_TANGENTS - WHEEL_BEARINGS) % (2.0 * np.pi), np.pi / 2.0)


def test_a_turn_to_the_left_runs_all_wheels_backwards_at_the_rim_speed_of_their_lever() -> None:
    assert_allclose(rims(0.0, 0.0, 0.5), -0.5 * LEVER[0])


def test_motors_turn_at_multiples_of_their_resolution() -> None:
    motors = StepMotors(OmniConfig(rate_resolution_hz=7.0), LEVER, STEP_S)

    rates = motors.wanted_rates(np.array([[0.031, 0.012, 0.1]]))

    assert_allclose(rates / 7.0, np.rint(rates / 7.0))
    assert np.abs(rates).max() > 0.0


def test_a_velocity_beyond_the_motors_is_slowed_down_in_its_own_direction() -> None:
    config = OmniConfig(rate_resolution_hz=0.001)
    motors = StepMotors(config, LEVER, STEP_S)
    wanted = np.array([[1.0, 0.4, 0.3]])

    rates = motors.wanted_rates(wanted)
    rim_per_step = 2.0 * np.pi * config.wheel_radius_m / config.steps_per_turn
    reached = apply(unmixing_matrices(LEVER), rates * rim_per_step)

    assert np.abs(rates).max() == pytest.approx(config.rate_max_hz)
    assert_allclose(reached / reached[0, 0], wanted / wanted[0, 0], atol=1e-4)


def test_saturated_rates_are_multiples_within_the_bound() -> None:
    motors = StepMotors(OmniConfig(rate_resolution_hz=7.0), LEVER, STEP_S)

    rates = motors.wanted_rates(np.array([[1.0, 0.4, 0.3]]))

    assert np.abs(rates).max() == pytest.approx(994.0)  # 143 would be 1001 Hz
    assert_allclose(rates / 7.0, np.rint(rates / 7.0))


def test_motors_speed_up_no_faster_than_their_ramp_and_arrive() -> None:
    config = OmniConfig()
    motors = StepMotors(config, LEVER, STEP_S)
    setpoint = np.array([[0.1, 0.0, 0.0]])
    wanted = motors.wanted_rates(setpoint)

    rates = [motors.rates]
    for _ in range(30):
        motors.advance(setpoint)
        rates.append(motors.rates)

    assert np.abs(np.diff(rates, axis=0)).max() <= config.rate_ramp_hzps * STEP_S + 1e-9
    assert_allclose(rates[-1], wanted)


def test_a_ramp_keeps_the_direction() -> None:
    motors = StepMotors(OmniConfig(), LEVER, STEP_S)

    first = apply(unmixing_matrices(LEVER), motors.advance(np.array([[0.08, 0.04, 0.0]])))[0]

    assert first[1] / first[0] == pytest.approx(0.5, abs=0.02)  # to within the resolution of the rates
    assert abs(first[2]) < 0.02


def test_slip_is_as_large_and_remembers_as_long_as_configured() -> None:
    config = OmniConfig(slip_sigma=0.05, slip_time_s=0.2)
    slip = WheelSlip(config, 50, STEP_S, np.random.default_rng(1))

    factors = np.stack([slip.advance() for _ in range(600)])
    off = factors - 1.0
    lag = round(config.slip_time_s / STEP_S)

    assert off.std() == pytest.approx(0.05, rel=0.05)
    assert off.mean() == pytest.approx(0.0, abs=0.003)
    assert (off[lag:] * off[:-lag]).mean() / off.var() == pytest.approx(np.exp(-1.0), abs=0.05)


def test_slip_of_one_seed_is_the_same_again() -> None:
    one, other = (WheelSlip(OmniConfig(), 3, STEP_S, np.random.default_rng(4)) for _ in range(2))

    assert_array_equal([one.advance() for _ in range(5)], [other.advance() for _ in range(5)])
