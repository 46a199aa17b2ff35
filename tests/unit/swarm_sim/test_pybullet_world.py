"""What only the back end with contacts can show: walls, pushes, rough ground."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from arena import BOUNDS, make_config, make_robot, make_row, make_scene, rectangle
from numpy.testing import assert_allclose

from swarm_msgs_py.robots import THESIS_TYPES
from swarm_sim.config import Backend, Ground, TerrainConfig
from swarm_sim.scene import RobotSpec
from swarm_sim.world.chassis import CENTER_HEIGHT_M
from swarm_sim.world.terrain import make_terrain

pytest.importorskip("pybullet")
from swarm_sim.world.pybullet_world import PyBulletWorld

DEPTH = 0.015  # what two bodies that run into each other at 1 m/s may share for a moment: one step of motion [m]
SEED = 3


class Bench:
    """Builds worlds and closes them."""

    def __init__(self) -> None:
        self._worlds: list[PyBulletWorld] = []

    def __call__(
        self, robots: Sequence[RobotSpec], obstacles: Sequence[np.ndarray] = (), ground: Ground = Ground.PLANE
    ) -> PyBulletWorld:
        self._worlds.append(PyBulletWorld(make_config(Backend.BULLET, ground), make_scene(robots, obstacles), SEED))
        return self._worlds[-1]

    def close(self) -> None:
        for world in self._worlds:
            world.close()


@pytest.fixture
def make() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.close()


def drive(world: PyBulletWorld, ticks: int, forward: Sequence[float]) -> np.ndarray:
    """Return the sampled positions (m, n, 2) of a drive along each robot's own x axis."""
    setpoints = np.zeros((len(forward), 3))
    setpoints[:, 0] = forward
    return np.concatenate([world.advance(setpoints).samples for _ in range(ticks)])


@pytest.mark.parametrize("ground", Ground, ids=lambda ground: ground.value)
def test_a_wall_stops_every_type_at_its_coverage_radius(make: Bench, ground: Ground) -> None:
    robots = tuple(make_robot(i, (0.0, 2.0 * i - 2.0), kind) for i, kind in enumerate(THESIS_TYPES))
    world = make(robots, [rectangle(2.0, -4.0, 3.0, 4.0)], ground)

    gaps = 2.0 - drive(world, 16, [0.5] * 3)[:, :, 0] - [kind.coverage_radius_m for kind in THESIS_TYPES]

    assert gaps.min() > -DEPTH
    assert_allclose(gaps[-1], 0.0, atol=DEPTH)
    assert_allclose(world.state.velocities, 0.0, atol=0.01)


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_robots_of_all_types_stop_each_other(make: Bench, first: int, second: int) -> None:
    kinds = THESIS_TYPES[first], THESIS_TYPES[second]
    world = make((make_robot(0, (-1.5, 0.0), kinds[0]), make_robot(1, (1.5, 0.02), kinds[1], yaw=np.pi)))

    samples = drive(world, 14, [0.5, 0.5])

    contact = sum(kind.coverage_radius_m for kind in kinds)
    distances = np.hypot(*(samples[:, 0] - samples[:, 1]).T)
    assert distances.min() > contact - DEPTH
    assert distances.min() < contact + DEPTH  # they did meet


def test_a_robot_that_is_pushed_gives_way_and_pushes_back(make: Bench) -> None:
    world = make((make_robot(0, (-1.0, 0.0)), make_robot(1, (0.0, 0.0))))

    samples = drive(world, 12, [0.5, 0.0])

    assert samples[-1, 1, 0] > 0.1  # moved
    assert samples[-1, 0, 0] < 0.5 * 6.0 - 1.0 - 0.5  # and was in the way


def test_a_robot_keeps_its_heading_when_it_scrapes_along_a_wall(make: Bench) -> None:
    world = make((make_robot(0, (0.0, 0.0), THESIS_TYPES[1], yaw=0.5),), [rectangle(-4.0, 0.8, 4.0, 1.6)])

    samples = drive(world, 12, [0.5])

    assert samples[-1, 0, 0] - samples[0, 0, 0] > 1.0
    assert world.state.yaws[0] == pytest.approx(0.5, abs=0.12)  # what the wall's friction twists against the servo


def test_robots_stand_on_the_ground_where_they_are(make: Bench) -> None:
    world = make(make_row(9), ground=Ground.ROUGH)
    terrain = make_terrain(TerrainConfig(margin_m=5.0), BOUNDS, SEED)

    ground = terrain.heights_at(world.state.positions)

    assert np.ptp(ground) > 0.05  # the ground under them is not flat
    assert_allclose(world.state.heights - CENTER_HEIGHT_M, ground, atol=0.02)


def test_a_parked_swarm_stays_on_rough_ground(make: Bench) -> None:
    world = make(make_row(9), ground=Ground.ROUGH)
    before = world.state.positions

    drive(world, 20, [0.0] * 9)

    assert_allclose(world.state.positions, before, atol=0.02)
    assert_allclose(world.state.velocities, 0.0, atol=2e-3)


def test_speed_is_held_up_and_down_the_waves_of_rough_ground(make: Bench) -> None:
    robots = tuple(make_robot(i, (-8.0, 3.0 * i - 4.5), THESIS_TYPES[i % 3]) for i in range(4))
    world = make(robots, ground=Ground.ROUGH)
    drive(world, 2, [0.5] * 4)
    setpoints = np.tile([0.5, 0.0, 0.0], (4, 1))

    speeds = np.concatenate([world.advance(setpoints).sample_velocities for _ in range(50)])

    assert np.ptp(world.state.heights) > 0.02
    deviation = np.hypot(*np.moveaxis(speeds, -1, 0)) - 0.5
    assert np.abs(deviation).max() < 0.1  # on the crease between two facets
    assert np.sqrt((deviation**2).mean()) < 0.02


def test_nobody_falls_off_the_world(make: Bench) -> None:
    world = make((make_robot(0, (9.0, 0.0), THESIS_TYPES[0]),))

    samples = drive(world, 40, [0.5])

    assert samples[-1, 0, 0] < BOUNDS[2] + 5.0  # margin of the ground
    assert world.state.heights[0] == pytest.approx(CENTER_HEIGHT_M, abs=0.01)


def test_bodies_pass_no_wall_between_convex_pieces(make: Bench) -> None:
    bay = np.array([(2.0, -3.0), (4.0, -3.0), (4.0, 3.0), (2.0, 3.0), (2.0, 2.0), (3.0, 2.0), (3.0, -2.0), (2.0, -2.0)])
    world = make(tuple(make_robot(i, (0.0, y)) for i, y in enumerate((-2.5, 0.0, 2.5))), [bay])

    samples = drive(world, 20, [0.5] * 3)

    assert_allclose(samples[-1, :, 0], [1.85, 2.85, 1.85], atol=DEPTH)  # arms stop at x = 2, the bay's floor at x = 3
