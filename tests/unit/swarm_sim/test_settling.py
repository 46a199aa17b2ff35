from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics.settling import Settling, settling

CONTOUR = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
TIMES = np.arange(0.0, 10.01, 0.1)


def evaluated(positions: FloatArray, velocities: FloatArray) -> Settling:
    return settling(TIMES, positions, velocities, CONTOUR, speed_max=0.01, hold=3.0)


def resting_from(*arrivals: float) -> tuple[FloatArray, FloatArray]:
    """Robots that drive along x at 0.1 m/s until they come to rest at the origin."""
    velocities = np.zeros((len(TIMES), len(arrivals), 2))
    velocities[..., 0] = np.where(TIMES[:, None] < np.array(arrivals), 0.1, 0.0)
    positions = np.zeros_like(velocities)
    positions[..., 0] = -0.1 * np.clip(np.array(arrivals) - TIMES[:, None], 0.0, None)
    return positions, velocities


def test_the_last_robot_decides() -> None:
    assert evaluated(*resting_from(2.0, 5.0)).time == pytest.approx(5.0)


def test_rest_that_was_not_held_long_enough_does_not_count() -> None:
    assert evaluated(*resting_from(2.0, 7.5)).time is None


def test_a_robot_that_rests_outside_keeps_the_swarm_unsettled() -> None:
    positions, velocities = resting_from(2.0, 3.0)
    positions[:, 1] += [1.5, 0.0]

    result = evaluated(positions, velocities)

    assert result.time is None
    assert result.inside_fraction == 0.5
    assert result.speed_p90 == 0.0


def test_a_twitch_restarts_the_clock() -> None:
    positions, velocities = resting_from(2.0, 3.0)
    velocities[60, 0] = [0.02, 0.0]

    assert evaluated(positions, velocities).time == pytest.approx(6.1)


def test_the_speed_threshold_itself_is_motion() -> None:
    positions, velocities = resting_from(2.0)
    velocities[-1] = [0.01, 0.0]

    assert evaluated(positions, velocities).time is None
