from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.errors import ConfigError
from swarm_sim.config import Ground, TerrainConfig
from swarm_sim.world.terrain import CELL_M, Terrain, make_terrain

ARENA = (-50.0, -50.0, 50.0, 50.0)


def test_the_seed_makes_the_ground() -> None:
    assert_array_equal(make_terrain(TerrainConfig(), ARENA, 1).heights, make_terrain(TerrainConfig(), ARENA, 1).heights)
    assert (
        np.abs(make_terrain(TerrainConfig(), ARENA, 1).heights - make_terrain(TerrainConfig(), ARENA, 2).heights).max()
        > 0.1
    )


@pytest.mark.parametrize("amplitude", [0.05, 0.12])
def test_amplitude_is_the_standard_deviation_of_the_height_in_the_arena(amplitude: float) -> None:
    terrain = make_terrain(TerrainConfig(amplitude_m=amplitude), ARENA, 1)
    inside = terrain.heights[20:-20, 20:-20]

    assert inside.std() == pytest.approx(amplitude, rel=0.15)


def test_rougher_ground_is_steeper_at_the_same_amplitude() -> None:
    slopes = [
        np.hypot(
            *np.gradient(make_terrain(TerrainConfig(roughness=roughness, amplitude_m=0.05), ARENA, 1).heights, CELL_M)
        ).mean()
        for roughness in (0.0, 0.5, 1.0)
    ]

    assert slopes[0] < slopes[1] < slopes[2]


def test_the_ground_is_flat_well_beyond_the_arena() -> None:
    terrain = make_terrain(TerrainConfig(margin_m=20.0), ARENA, 1)

    assert_array_equal(terrain.heights[:15], 0.0)
    assert_array_equal(terrain.heights[:, -15:], 0.0)


def test_slopes_stay_drivable_by_default() -> None:
    for seed in range(30):
        terrain = make_terrain(TerrainConfig(), ARENA, seed)
        # m g slope must leave most of the default drive force of 8 N to the heaviest type, 1.5 kg.
        assert np.hypot(*np.gradient(terrain.heights, CELL_M)).max() * 1.5 * 9.81 < 4.0


def test_ground_that_would_topple_robots_is_refused() -> None:
    with pytest.raises(ConfigError, match="lower amplitude_m"):
        make_terrain(TerrainConfig(amplitude_m=0.3), ARENA, 1)


def test_a_plane_is_flat() -> None:
    assert not make_terrain(TerrainConfig(ground=Ground.PLANE), ARENA, 1).heights.any()


def test_height_between_grid_points_is_never_below_the_facets() -> None:
    cell = Terrain(np.array([[0.0, 1.0], [1.0, 0.0]]), (0.0, 0.0))  # a saddle: the cut decides the middle

    assert_allclose(cell.heights_at(np.array([(0.0, 0.0), (1.0, 0.0), (0.5, 0.5), (0.5, 0.0)])), [0.0, 1.0, 1.0, 0.5])


def test_the_grid_lies_about_the_arena() -> None:
    terrain = make_terrain(TerrainConfig(margin_m=5.0), (0.0, -10.0, 20.0, 30.0), 1)

    assert terrain.center == (10.0, 10.0)
    assert terrain.heights.shape == (51, 31)
