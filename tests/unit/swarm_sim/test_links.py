from __future__ import annotations

import numpy as np
from arena import rectangle

from swarm_sim.radio.links import LinkModel
from swarm_sim.world.obstacles import ObstacleField

ALIVE = np.ones(3, dtype=np.bool_)


def connected(positions: list[tuple[float, float]], obstacles: list[np.ndarray], alive: np.ndarray = ALIVE) -> set:
    table = LinkModel(25.0, ObstacleField(obstacles)).evaluate(np.array(positions), alive)
    assert (table.connected == table.connected.T).all()
    return {(int(a), int(b)) for a, b in zip(*np.nonzero(table.connected), strict=True) if a < b}


def test_radios_hear_each_other_below_the_range() -> None:
    assert connected([(0.0, 0.0), (24.99, 0.0), (50.0, 0.0)], []) == {(0, 1)}  # 25.01 m from the second to the third


def test_the_range_itself_is_out_of_range() -> None:
    assert connected([(0.0, 0.0), (25.0, 0.0), (0.0, 1.0)], []) == {(0, 2)}


def test_an_obstacle_between_two_radios_cuts_their_link() -> None:
    assert connected([(0.0, 0.0), (4.0, 0.0), (2.0, 5.0)], [rectangle(1.9, -1.0, 2.1, 1.0)]) == {(0, 2), (1, 2)}


def test_other_robots_do_not_block() -> None:
    assert connected([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], []) == {(0, 1), (0, 2), (1, 2)}


def test_a_dead_radio_has_no_link() -> None:
    assert connected([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], [], np.array([True, False, True])) == {(0, 2)}
