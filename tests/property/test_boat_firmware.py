"""Thruster allocation and the extended-state observer, for any gains and any wrench."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_msgs_py.errors import ConfigError
from swarm_sim.boats.config import ThrusterConfig
from swarm_sim.boats.ladrc import Ladrc, LadrcGains, observer_matrices
from swarm_sim.boats.pose_control import Reference
from swarm_sim.boats.thrusters import allocate, allocation_matrix, feasible

FORCES = st.floats(-5.0, 5.0)
GAINS = st.floats(0.1, 200.0)
ARMS = st.floats(0.02, 0.5)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(FORCES, FORCES, FORCES, ARMS)
def test_thrusts_make_up_the_wrench_with_the_least_effort(surge: float, sway: float, yaw: float, arm: float) -> None:
    wrench = np.array([[surge, sway, yaw]])
    matrix = allocation_matrix(arm)

    thrusts = allocate(wrench, arm)

    assert np.allclose(thrusts @ matrix.T, wrench, atol=1e-9)
    assert np.allclose(thrusts[0], np.linalg.pinv(matrix) @ wrench[0], atol=1e-9)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(FORCES, FORCES, st.floats(-0.6, 0.6))
def test_what_is_feasible_keeps_all_limits_and_the_direction_of_the_force(
    surge: float, sway: float, yaw: float
) -> None:
    config = ThrusterConfig()
    asked = np.array([[surge, sway, yaw]])

    can = feasible(asked, config)

    assert np.abs(allocate(can, config.arm_m)).max() <= config.force_max_n + 1e-12
    assert abs(surge * can[0, 1] - sway * can[0, 0]) < 1e-9
    assert np.dot(can[0, :2], asked[0, :2]) >= 0.0
    assert can[0, 2] == pytest.approx(np.clip(yaw, -0.4, 0.4))
    if np.abs(allocate(asked, config.arm_m)).max() <= config.force_max_n:
        assert np.allclose(can, asked)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(GAINS, GAINS, GAINS, st.floats(0.002, 0.02))
def test_the_sampled_observer_is_stable_exactly_where_routh_says_so(
    a1: float, a2: float, a3: float, step: float
) -> None:
    axis = a1, a2, a3
    if abs(a1 * a2 - a3) < 1e-3 * a3:
        return  # too near to the edge for rounding
    if a1 * a2 <= a3:
        with pytest.raises(ConfigError, match="unstable"):
            LadrcGains((1.0,) * 3, (2.0,) * 3, (axis,) * 3)
        return

    transition, _ = observer_matrices(LadrcGains((1.0,) * 3, (2.0,) * 3, (axis,) * 3), step)

    assert np.abs(np.linalg.eigvals(transition[0])).max() < 1.0


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.floats(-0.5, 0.5), st.floats(3.0, 30.0))
def test_the_observer_finds_any_constant_disturbance(push: float, bandwidth: float) -> None:
    gains = LadrcGains((1.0,) * 3, (2.0,) * 3, ((3.0 * bandwidth, 3.0 * bandwidth**2, bandwidth**3),) * 3)
    step, pose, velocity = 0.01, np.zeros((1, 3)), np.zeros((1, 3))
    law = Ladrc([gains], pose, step)
    reference = Reference(np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 3)))

    for _ in range(1000):
        thrust = law.command(pose, reference, np.zeros(1, dtype=np.bool_))
        law.applied(thrust, np.zeros(1, dtype=np.bool_))
        pose = pose + step * velocity + 0.5 * step**2 * (thrust + push)
        velocity = velocity + step * (thrust + push)

    assert np.allclose(law.disturbance, push, atol=0.01)
    assert np.abs(pose).max() < 0.01
