import numpy as np
import pytest
from numpy.testing import assert_allclose

from mission_computer.shape import load_shape
from swarm_agent.forces.config import SharingForceConfig
from swarm_agent.forces.shares import Claim, Shares
from swarm_msgs_py.types import FloatArray

STRIP = np.array([[-6.0, -1.0], [6.0, -1.0], [6.0, 1.0], [-6.0, 1.0]])
NOBODY = np.empty((0, 2))
PITCH = 0.14  # of 1500 points on 24 square meters


def shares_of(contour: FloatArray = STRIP, **settings: float) -> Shares:
    return Shares(SharingForceConfig(**{"range": 10.0, "spread_gain": 0.0, **settings}), contour)


def claim(shares: Shares, position: list[float], others: object = NOBODY) -> Claim:
    claimed = shares.claim(np.array(position), np.array(others, dtype=float).reshape(-1, 2))
    assert claimed is not None
    return claimed


def test_alone_the_whole_shape_is_ones_share() -> None:
    claimed = claim(shares_of(), [3.0, 0.5])

    assert claimed.area == pytest.approx(24.0)
    assert_allclose(claimed.way, [-3.0, -0.5], atol=0.5 * PITCH)


def test_two_robots_share_by_the_line_between_them() -> None:
    claimed = claim(shares_of(), [-1.0, 0.0], [[3.0, 0.0]])  # the line is at x = 1

    assert claimed.area == pytest.approx(14.0, rel=0.02)
    assert_allclose(claimed.way, [-2.5 - -1.0, 0.0], atol=0.5 * PITCH)


def test_the_shares_of_a_swarm_add_up_to_the_shape() -> None:
    contour = load_shape("formation_2")
    shares = shares_of(contour)
    robots = contour.mean(axis=0) + np.random.default_rng(1).uniform(-8.0, 8.0, (20, 2))

    areas = [
        0.0 if (claimed := shares.claim(robot, np.delete(robots, row, axis=0))) is None else claimed.area
        for row, robot in enumerate(robots)
    ]

    assert sum(areas) == pytest.approx(310.0, rel=1e-6)


def test_out_of_reach_there_is_no_share() -> None:
    assert shares_of(range=0.5).claim(np.array([20.0, 0.0]), NOBODY) is None


def test_behind_others_there_is_no_share() -> None:
    screen = np.column_stack([np.linspace(-6.0, 6.0, 30), np.full(30, 0.8)])

    assert shares_of().claim(np.array([0.0, 3.0]), screen) is None


def test_a_crowd_on_one_side_drives_a_robot_to_the_other() -> None:
    crowd = [[1.0, 0.3], [1.0, -0.3], [2.0, 0.4], [2.0, -0.4], [3.0, 0.0]]

    without, with_spread = (claim(shares_of(spread_gain=gain), [0.0, 0.0], crowd).way[0] for gain in (0.0, 1.0))

    assert with_spread < without


def test_an_even_row_is_not_driven_anywhere() -> None:
    row = np.column_stack([np.arange(-5.0, 6.0, 2.0), np.zeros(6)])

    claimed = claim(shares_of(spread_gain=1.0), row[2].tolist(), np.delete(row, 2, axis=0))

    assert_allclose(claimed.way, 0.0, atol=0.5 * PITCH)
