from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import THESIS_TYPES, RobotType
from swarm_sim.config import GainSet
from swarm_sim.firmware.servo_gains import gains_of, lqr_gains, lqr_gains_closed_form, servo_gains

# Spec section 12.2: K_e, K_v, 2 % settling time [s], overshoot [%], bandwidth [rad/s], per type.
SPEC = {
    GainSet.WEIGHTS: [(7.50, 4.12, 1.42, 0.4, 2.4), (7.50, 4.41, 1.48, 0.8, 2.3), (7.50, 5.21, 1.66, 1.6, 2.0)],
    GainSet.TABLE_4_2: [(237, 96, 1.56, 0, 2.5), (263, 112, 1.64, 0, 2.4), (297, 121, 1.56, 0, 2.5)],
    GainSet.RECOMMENDED: [
        (113.3, 13.33, 0.50, 4.4, 11.9),
        (141.6, 16.65, 0.50, 4.4, 11.9),
        (212.4, 25.11, 0.50, 4.4, 11.9),
    ],
}
CASES = [
    pytest.param(gain_set, kind, row, id=f"{gain_set.value}-{kind.type}")
    for gain_set, rows in SPEC.items()
    for kind, row in zip(THESIS_TYPES, rows, strict=True)
]


def step_response(kind: RobotType, gains: tuple[float, float], times: np.ndarray) -> np.ndarray:
    """Velocity over setpoint of s^2 + (b + K_v)/m s + K_e/m, by partial fractions."""
    error, speed = gains
    poles = np.roots([1.0, (kind.mu2 + speed) / kind.mass_kg, error / kind.mass_kg]).astype(complex)
    p, q = poles
    return np.real(1.0 + (q * np.exp(p * times) - p * np.exp(q * times)) / (p - q))


@pytest.mark.parametrize(("gain_set", "kind", "row"), CASES)
def test_gains_are_those_of_the_specification(gain_set: GainSet, kind: RobotType, row: tuple[float, ...]) -> None:
    assert_allclose(gains_of(kind, gain_set), row[:2], rtol=2e-3)


@pytest.mark.parametrize(("gain_set", "kind", "row"), CASES)
def test_the_loop_settles_and_overshoots_as_specified(
    gain_set: GainSet, kind: RobotType, row: tuple[float, ...]
) -> None:
    times = np.linspace(0.0, 4.0, 8001)
    response = step_response(kind, gains_of(kind, gain_set), times)

    settled = times[np.flatnonzero(np.abs(response - 1.0) > 0.02)[-1]]

    assert settled == pytest.approx(row[2], abs=0.02)
    assert 100.0 * max(0.0, response.max() - 1.0) == pytest.approx(row[3], abs=0.1)


@pytest.mark.parametrize(("gain_set", "kind", "row"), CASES)
def test_the_loop_has_the_specified_bandwidth(gain_set: GainSet, kind: RobotType, row: tuple[float, ...]) -> None:
    error, speed = gains_of(kind, gain_set)
    omega = np.linspace(0.1, 20.0, 20000)
    s = 1j * omega
    gain = np.abs(error / (kind.mass_kg * s**2 + (kind.mu2 + speed) * s + error))

    assert omega[np.flatnonzero(gain < np.sqrt(0.5))[0]] == pytest.approx(row[4], abs=0.06)


@pytest.mark.parametrize("weights", [(0.0, 1.0, 1.0), (2.0 / 3.0, 6.25, 1.0 / 9.0), (5.0, 400.0, 0.01)])
@pytest.mark.parametrize("kind", THESIS_TYPES, ids=lambda kind: str(kind.type))
def test_the_riccati_equation_and_its_closed_form_agree(kind: RobotType, weights: tuple[float, float, float]) -> None:
    numeric = lqr_gains(kind.mass_kg, kind.mu2, weights)

    assert_allclose(numeric, lqr_gains_closed_form(kind.mass_kg, kind.mu2, weights), rtol=1e-6)


def test_table_4_2_knows_three_types_only() -> None:
    with pytest.raises(ConfigError, match="no robot type 4"):
        gains_of(replace(THESIS_TYPES[0], type=4), GainSet.TABLE_4_2)


def test_a_swarm_gets_one_row_of_gains_per_robot() -> None:
    mixed = [THESIS_TYPES[2], THESIS_TYPES[0], THESIS_TYPES[2]]

    gains = servo_gains(mixed, GainSet.RECOMMENDED)

    assert_allclose(gains.error, [212.4, 113.28, 212.4])
