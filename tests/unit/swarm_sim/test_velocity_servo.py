from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import THESIS_TYPES, RobotType
from swarm_sim.config import GainSet
from swarm_sim.firmware.servo_gains import servo_gains
from swarm_sim.firmware.velocity_servo import (
    HEADING_ACCELERATION_MAX,
    HEADING_ERROR_MAX,
    HeadingServo,
    VelocityServo,
    held_force_response,
    wrap_angle,
)

STEP_S = 1.0 / 60.0


def make_servo(*kinds: RobotType, gains: GainSet = GainSet.RECOMMENDED, step_s: float = STEP_S) -> VelocityServo:
    return VelocityServo(servo_gains(kinds, gains), kinds, step_s)


def test_force_is_the_lqr_law_on_the_integrated_error() -> None:
    servo = make_servo(THESIS_TYPES[0])

    force = servo.force(np.array([[0.3, 0.0]]), np.array([[0.1, 0.2]]))

    error = STEP_S * np.array([0.2, -0.2])
    assert_allclose(force[0], 113.28 * error - 13.33 * np.array([0.1, 0.2]), rtol=1e-3)


def test_a_saturated_force_keeps_its_direction_and_the_integrator_rests() -> None:
    servo = make_servo(replace(THESIS_TYPES[0], force_max_n=1.0), THESIS_TYPES[0])

    force = servo.force(np.array([[3.0, 4.0], [0.3, 0.4]]), np.zeros((2, 2)))

    assert_allclose(force[0], [0.6, 0.8])
    assert_array_equal(servo.error[0], [0.0, 0.0])
    assert_allclose(servo.error[1], STEP_S * np.array([0.3, 0.4]))  # the other robot's integrator runs


def test_a_part_of_a_servo_leaves_the_whole_alone() -> None:
    servo = make_servo(*THESIS_TYPES)
    part = servo.subset(np.array([2]))

    part.force(np.ones((1, 2)), np.zeros((1, 2)))

    assert part.error.any()
    assert not servo.error.any()


@pytest.mark.parametrize(
    ("gains", "step_s"),
    [(GainSet.RECOMMENDED, 0.05), (GainSet.WEIGHTS, 0.1), (GainSet.TABLE_4_2, 0.0125)],
    ids=lambda value: str(getattr(value, "value", value)),
)
def test_gains_are_accepted_at_steps_that_carry_them(gains: GainSet, step_s: float) -> None:
    servo = make_servo(*THESIS_TYPES, gains=gains, step_s=step_s)

    assert servo.step_s == step_s


@pytest.mark.parametrize("kind", THESIS_TYPES, ids=lambda kind: str(kind.type))
def test_table_4_2_gains_are_refused_at_a_step_of_50_ms(kind: RobotType) -> None:
    with pytest.raises(ConfigError, match=f"robot type {kind.type}"):
        make_servo(kind, gains=GainSet.TABLE_4_2, step_s=0.05)


@pytest.mark.parametrize("friction", [0.0, 1e-7, 0.13, 5.0])
def test_the_response_to_a_held_force_solves_the_equation_of_motion(friction: float) -> None:
    kind = replace(THESIS_TYPES[1], mu2=friction)
    decay, gain, glide, shift = held_force_response(kind, STEP_S)
    x, v, force, pieces = 0.0, 0.4, 2.0, 4000
    for _ in range(pieces):  # midpoint rule with tiny steps
        h = STEP_S / pieces
        middle = v + h / 2.0 * (force - friction * v) / kind.mass_kg
        x, v = x + h * middle, v + h * (force - friction * middle) / kind.mass_kg

    assert decay * 0.4 + gain * force == pytest.approx(v, rel=1e-9)
    assert glide * 0.4 + shift * force == pytest.approx(x, rel=1e-7)


def test_a_heading_within_tolerance_is_let_be() -> None:
    servo = HeadingServo(np.array([1.0]), STEP_S)

    assert servo.acceleration(np.zeros(1), np.array([1.001]), np.zeros(1)) == 0.0


def test_a_heading_that_was_pushed_away_is_turned_back() -> None:
    servo = HeadingServo(np.array([3.1]), STEP_S)

    for _ in range(10):
        back = servo.acceleration(np.zeros(1), np.array([-3.1]), np.zeros(1))  # 0.083 rad beyond, across the cut at pi

    assert -HEADING_ACCELERATION_MAX < back[0] < 0.0


def test_a_blocked_turn_does_not_wind_up() -> None:
    servo = HeadingServo(np.zeros(1), STEP_S)
    for _ in range(200):
        servo.acceleration(np.ones(1), np.zeros(1), np.zeros(1))

    held = servo.acceleration(np.zeros(1), np.array([HEADING_ERROR_MAX]), np.zeros(1))

    assert held[0] == pytest.approx(0.0, abs=1e-9)


def test_angles_wrap_into_half_open_turn() -> None:
    assert_allclose(wrap_angle(np.array([np.pi, -np.pi, 7.0, -7.0])), [-np.pi, -np.pi, 7 - 2 * np.pi, 2 * np.pi - 7])
