from __future__ import annotations

import numpy as np

from studies.wandering import RADIUS_M, SPEED_MAX_MPS, Wandering

PERIOD = 0.5
HOMES = np.array([[0.0, 0.0], [20.0, -5.0], [-7.0, 9.0]])


def drive(seed: int, yaws: np.ndarray, ticks: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and world velocities of bodies that do exactly what they are told."""
    wandering, positions = Wandering(HOMES, PERIOD, seed), HOMES.copy()
    places, velocities = [], []
    for _ in range(ticks):
        commands = wandering.step(positions, yaws)
        body = np.array([[command.forward, command.left] for command in commands])
        cos, sin = np.cos(yaws), np.sin(yaws)
        velocity = np.stack([cos * body[:, 0] - sin * body[:, 1], sin * body[:, 0] + cos * body[:, 1]], axis=1)
        positions = positions + PERIOD * velocity
        places.append(positions)
        velocities.append(velocity)
    return np.array(places), np.array(velocities)


def test_robots_keep_moving_below_top_speed_and_near_their_homes() -> None:
    places, velocities = drive(1, np.zeros(3))
    speeds = np.linalg.norm(velocities, axis=2)

    assert speeds.max() <= SPEED_MAX_MPS + 1e-9
    assert (speeds.mean(axis=0) > 0.1).all()
    assert np.linalg.norm(places - HOMES, axis=2).max() <= RADIUS_M + 1e-9


def test_the_way_over_ground_does_not_depend_on_the_heading() -> None:
    straight, _ = drive(3, np.zeros(3))
    turned, _ = drive(3, np.array([1.0, -2.0, 3.0]))

    np.testing.assert_allclose(turned, straight, atol=1e-9)


def test_a_seed_gives_one_motion() -> None:
    np.testing.assert_array_equal(drive(5, np.zeros(3))[0], drive(5, np.zeros(3))[0])
    assert not np.array_equal(drive(5, np.zeros(3))[0], drive(6, np.zeros(3))[0])
