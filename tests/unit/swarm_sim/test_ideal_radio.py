from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.errors import ConfigError
from swarm_sim.config import RadioConfig, RadioModel
from swarm_sim.radio.links import make_links
from swarm_sim.world.obstacles import ObstacleField

WALL = np.array([[4.0, -9.0], [5.0, -9.0], [5.0, 9.0], [4.0, 9.0]])
POSITIONS = np.array([[0.0, 0.0], [3.0, 0.0], [8.0, 0.0], [500.0, 0.0]])
ALIVE = np.ones(4, dtype=np.bool_)


def connected(model: RadioModel, alive: np.ndarray = ALIVE) -> list[tuple[int, int]]:
    table = make_links(RadioConfig(model=model), ObstacleField([WALL])).evaluate(POSITIONS, alive)
    assert np.array_equal(table.connected, table.connected.T)
    np.testing.assert_allclose(table.distances[0], [0.0, 3.0, 8.0, 500.0])
    return [(int(a), int(b)) for a, b in zip(*np.nonzero(table.connected), strict=True) if a <= b]


def test_ideal_radios_hear_each_other_through_walls_and_from_afar() -> None:
    assert connected(RadioModel.IDEAL) == [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]


def test_other_radios_do_not() -> None:
    assert connected(RadioModel.LINE_OF_SIGHT) == [(0, 1)]


def test_a_dead_radio_hears_nothing_however_ideal() -> None:
    assert connected(RadioModel.IDEAL, np.array([True, False, True, True])) == [(0, 2), (0, 3), (2, 3)]


@pytest.mark.parametrize("flaw", [{"loss": 0.1}, {"delay_ticks_max": 1}])
def test_what_is_ideal_loses_and_delays_nothing(flaw: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match="model ideal loses and delays nothing"):
        RadioConfig(model=RadioModel.IDEAL, **flaw)  # type: ignore[arg-type]
