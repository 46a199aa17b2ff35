"""What every physics back end must do with omni-wheel robots; one suite, run on each of them."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import NodeId
from swarm_sim.config import (
    Backend,
    Drive,
    DriveConfig,
    Ground,
    OmniConfig,
    PhysicsConfig,
    SimConfig,
    TerrainConfig,
)
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.world.registry import make_world
from swarm_sim.world.world import World

HAS_BULLET = importlib.util.find_spec("pybullet") is not None
BACKENDS = [
    Backend.MASSDAMPER,
    pytest.param(Backend.BULLET, marks=pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")),
]
RADII = (0.16, 0.11, 0.11, 0.08, 0.08)
PLACES = ((-0.62, -0.72), (-0.82, 0.3), (0.8, -0.3), (-0.15, 0.86), (0.55, 0.8))
RESOLUTION_MPS = 2.0 * np.pi * OmniConfig().wheel_radius_m / OmniConfig().steps_per_turn
MakeWorld = Callable[..., World]


def make_scene(places: tuple[tuple[float, float], ...] = PLACES, yaw: float = 0.0) -> Scene:
    robots = tuple(
        RobotSpec(
            NodeId(i),
            RobotType(type=i + 1, mass_kg=5.0 * radius, mu1=0.5, mu2=0.1, coverage_radius_m=radius),
            place,
            yaw,
            False,
        )
        for i, (radius, place) in enumerate(zip(RADII, places, strict=False))
    )
    return Scene(robots, (), (-1.0, -1.0, 1.0, 1.0), (0.0, 0.0))


def make_config(backend: Backend, **omni: Any) -> SimConfig:
    return SimConfig(
        physics=PhysicsConfig(backend=backend),
        terrain=TerrainConfig(ground=Ground.PLANE, margin_m=2.0),
        drive=DriveConfig(kind=Drive.OMNI_WHEELS, omni=OmniConfig(**({"slip_sigma": 0.0} | omni))),
    )


@pytest.fixture(params=BACKENDS, ids=lambda backend: backend.value)
def backend(request: pytest.FixtureRequest) -> Backend:
    return request.param


@pytest.fixture
def make(backend: Backend) -> Iterator[MakeWorld]:
    opened: list[World] = []

    def make_one(scene: Scene | None = None, seed: int = 3, **omni: Any) -> World:
        opened.append(make_world(make_config(backend, **omni), scene or make_scene(), seed))
        return opened[-1]

    yield make_one
    for world in opened:
        world.close()


def command(world: World, forward: float = 0.0, left: float = 0.0, turn: float = 0.0) -> np.ndarray:
    return np.tile([forward, left, turn], (len(world.state.yaws), 1))


def test_robots_stand_still_where_the_scene_puts_them(make: MakeWorld) -> None:
    world = make(make_scene(yaw=0.4))

    motion = world.advance(command(world))

    assert_allclose(motion.end.positions, PLACES, atol=1e-4)
    assert_allclose(motion.end.yaws, 0.4, atol=1e-4)
    assert_allclose(motion.end.velocities, 0.0, atol=1e-5)


def test_robots_of_all_sizes_go_as_fast_as_their_motors_resolve(make: MakeWorld) -> None:
    world = make(make_scene(yaw=np.pi / 2.0))

    for _ in range(2):
        motion = world.advance(command(world, forward=0.04, left=0.03))

    assert_allclose(motion.end.velocities, np.tile([-0.03, 0.04], (5, 1)), atol=2.0 * RESOLUTION_MPS)
    assert_allclose(motion.end.positions - motion.start.positions, np.tile([-0.015, 0.02], (5, 1)), atol=2e-4)


def test_a_turning_robot_drives_a_circle(make: MakeWorld) -> None:
    world = make(make_scene(((0.0, 0.0),)))
    turn, speed = 0.5, 0.05

    for _ in range(round(2.0 * np.pi / turn / 0.5)):
        motion = world.advance(command(world, forward=speed, turn=turn))

    # Radius 0.1 m; the ramp, the resolution of the rates and the last incomplete tick leave a centimeter.
    assert_allclose(motion.end.positions, 0.0, atol=0.012)
    assert motion.end.yaw_rates[0] == pytest.approx(turn, abs=0.02)


def test_more_than_the_motors_can_is_driven_slower_in_the_same_direction(make: MakeWorld) -> None:
    world = make()

    world.advance(command(world, forward=0.5, left=0.5))
    motion = world.advance(command(world, forward=0.5, left=0.5))

    fastest = OmniConfig().rate_max_hz * RESOLUTION_MPS
    assert_allclose(motion.end.velocities[:, 1] / motion.end.velocities[:, 0], 1.0, atol=0.01)
    assert np.hypot(*motion.end.velocities.T).max() <= fastest / np.cos(np.pi / 6.0)
    assert np.hypot(*motion.end.velocities.T).min() >= 0.99 * fastest


def test_slip_makes_a_robot_stray_a_little_and_turn(make: MakeWorld) -> None:
    ideal, slipping = make(), make(slip_sigma=0.05)
    for _ in range(8):
        exact = ideal.advance(command(ideal, forward=0.05)).end
        real = slipping.advance(command(slipping, forward=0.05)).end

    strayed = np.hypot(*(real.positions - exact.positions).T)
    assert strayed.max() < 0.02  # of 0.2 m
    assert strayed.min() > 1e-5
    assert np.abs(real.yaws - exact.yaws).max() > 1e-3


def test_slip_belongs_to_the_seed(make: MakeWorld) -> None:
    one, same, other = make(seed=1, slip_sigma=0.05), make(seed=1, slip_sigma=0.05), make(seed=2, slip_sigma=0.05)
    for _ in range(3):
        ends = [world.advance(command(world, forward=0.05)).end.positions.tobytes() for world in (one, same, other)]

    assert ends[0] == ends[1]
    assert ends[0] != ends[2]


@pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")
def test_the_back_ends_drive_the_same_course_on_free_ground() -> None:
    worlds = [make_world(make_config(backend), make_scene(), seed=0) for backend in Backend]
    rng = np.random.default_rng(1)
    for _ in range(10):
        setpoints = np.column_stack([rng.uniform(-0.04, 0.04, (5, 2)), rng.uniform(-0.4, 0.4, 5)])
        ends = [world.advance(setpoints).end for world in worlds]
    for world in worlds:
        world.close()

    assert_allclose(ends[0].positions, ends[1].positions, atol=2e-3)
    assert_allclose(ends[0].yaws, ends[1].yaws, atol=0.01)


@pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")
def test_a_robot_that_runs_into_another_is_stopped_by_it_or_pushes_it_but_never_enters_it() -> None:
    scene = make_scene(((-0.2, 0.0), (0.12, 0.0)))
    world = make_world(make_config(Backend.BULLET), scene, seed=0)
    setpoints = np.array([[0.05, 0.0, 0.0], [0.0, 0.0, 0.0]])

    gaps = []
    for _ in range(8):
        end = world.advance(setpoints).end
        gaps.append(np.hypot(*(end.positions[1] - end.positions[0])) - RADII[0] - RADII[1])
    world.close()

    assert min(gaps) < 0.002  # they met
    assert min(gaps) > -0.003
