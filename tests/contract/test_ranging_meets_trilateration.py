"""What the world's ranging radios measure, a robot's trilateration turns into what the noise model promises."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from swarm_agent.localization.trilateration import Trilateration, trilaterate
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import RangingConfig, RangingModel
from swarm_sim.radio.links import LinkModel
from swarm_sim.sensors.ranging import Ranging
from swarm_sim.world.obstacles import ObstacleField

ROUNDS, SIGMA = 400, 2.0
ROBOTS = np.array([(0.0, 0.0), (9.0, 2.0), (-6.0, 8.0), (-4.0, -9.0), (5.0, -5.0), (20.0, 16.0)])


def errors_of_fixes(model: RangingModel, sigma: float) -> tuple[FloatArray, FloatArray]:
    """Return the errors of all fixes of the first robot (k, 2) and their root mean square residuals (k,) [m]."""
    links = LinkModel(25.0, ObstacleField([])).evaluate(ROBOTS, np.ones(len(ROBOTS), dtype=np.bool_))
    config = RangingConfig(model=model, sigma_m=SIGMA, period_s=0.0)
    ranging = Ranging(config, np.arange(len(ROBOTS)), 0.5, seed=4)
    errors, residuals = [], []
    for tick in range(ROUNDS):
        scan = ranging.measure(tick, ROBOTS, links)[0]
        assert scan.neighbors.tolist() == [1, 2, 3, 4]  # the last robot is out of reach
        fix = trilaterate(ROBOTS[scan.neighbors], scan.ranges, ROBOTS[0], np.eye(2), sigma)
        assert isinstance(fix, Trilateration)
        errors.append(fix.position - ROBOTS[0])
        residuals.append(np.sqrt(fix.squared_residual / len(scan.ranges)))
    return np.array(errors), np.array(residuals)


def test_in_the_model_position_every_fix_is_exactly_the_displaced_point() -> None:
    errors, residuals = errors_of_fixes(RangingModel.POSITION, 0.0)

    # All circles meet there, so it is the one point that the radio ranged from, not just near it.
    assert residuals.max() < 1e-9
    assert_allclose(errors.mean(axis=0), 0.0, atol=4.0 * SIGMA / np.sqrt(ROUNDS))
    assert_allclose(errors.std(axis=0), SIGMA, rtol=0.12)
    assert abs(np.corrcoef(errors.T)[0, 1]) < 0.2


def test_in_the_model_range_the_circles_do_not_meet_and_geometry_decides() -> None:
    errors, residuals = errors_of_fixes(RangingModel.RANGE, SIGMA)

    lines = ROBOTS[1:5] / np.hypot(*ROBOTS[1:5].T)[:, None]
    promised = SIGMA * np.sqrt(np.diag(np.linalg.inv(lines.T @ lines)))
    assert np.median(residuals) > 0.25 * SIGMA
    assert_allclose(errors.std(axis=0), promised, rtol=0.15)
