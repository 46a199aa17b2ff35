"""The wheel mixing of the omni robots and its inverse, for any lever and motion."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from swarm_sim.firmware.omni_wheels import apply, mixing_matrices, unmixing_matrices

LEVERS = st.floats(0.02, 0.3)
SPEEDS = st.floats(-1.0, 1.0)
RATES = st.floats(-5.0, 5.0)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(lever=LEVERS, forward=SPEEDS, left=SPEEDS, turn=RATES)
def test_unmixing_the_rim_speeds_gives_back_the_body_velocity(
    lever: float, forward: float, left: float, turn: float
) -> None:
    levers, body = np.array([lever]), np.array([[forward, left, turn]])

    assert_allclose(apply(unmixing_matrices(levers), apply(mixing_matrices(levers), body)), body, atol=1e-9)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(lever=LEVERS, a=SPEEDS, b=SPEEDS, c=SPEEDS)
def test_mixing_the_body_velocity_gives_back_any_rim_speeds(lever: float, a: float, b: float, c: float) -> None:
    levers, rims = np.array([lever]), np.array([[a, b, c]])

    assert_allclose(apply(mixing_matrices(levers), apply(unmixing_matrices(levers), rims)), rims, atol=1e-9)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(lever=LEVERS, forward=SPEEDS, left=SPEEDS)
def test_without_a_turn_the_rim_speeds_add_up_to_nothing(lever: float, forward: float, left: float) -> None:
    rims = apply(mixing_matrices(np.array([lever])), np.array([[forward, left, 0.0]]))

    assert_allclose(rims.sum(), 0.0, atol=1e-12)
    assert_allclose((rims**2).sum(), 1.5 * (forward**2 + left**2), atol=1e-9)  # no direction costs more
