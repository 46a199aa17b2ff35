"""What every physics back end must do; one suite, run on each of them."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from arena import make_config, make_robot, make_row, make_scene
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.errors import ConfigError, PhysicsError
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_sim.config import Backend, GainSet, Ground, ServoConfig, SimConfig
from swarm_sim.scene import Scene
from swarm_sim.world.registry import make_world
from swarm_sim.world.world import SAMPLE_HZ, World

HAS_BULLET = importlib.util.find_spec("pybullet") is not None
BACKENDS = [
    Backend.MASSDAMPER,
    pytest.param(Backend.BULLET, marks=pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")),
]
MakeWorld = Callable[..., World]
FINE_S = 0.05  # a control period that resolves the servo's transient


@pytest.fixture(params=BACKENDS, ids=lambda backend: backend.value)
def backend(request: pytest.FixtureRequest) -> Backend:
    return request.param


@pytest.fixture
def make(backend: Backend) -> Iterator[MakeWorld]:
    opened: list[World] = []

    def make_one(scene: Scene | None = None, config: SimConfig | None = None) -> World:
        opened.append(make_world(config or make_config(backend), scene or make_scene(), seed=3))
        return opened[-1]

    yield make_one
    for world in opened:
        world.close()


def command(world: World, forward: float = 0.0, left: float = 0.0, turn: float = 0.0) -> np.ndarray:
    return np.tile([forward, left, turn], (len(world.state.yaws), 1))


def test_bodies_start_at_rest_where_the_scene_puts_them(make: MakeWorld) -> None:
    world = make(make_scene((make_robot(0, (1.0, 2.0), yaw=0.5), make_robot(1, (-3.0, 0.0), THESIS_TYPES[2]))))

    assert_allclose(world.state.positions, [(1.0, 2.0), (-3.0, 0.0)], atol=1e-3)
    assert_allclose(world.state.yaws, [0.5, 0.0], atol=1e-3)
    assert_allclose(world.state.velocities, 0.0, atol=1e-3)


def test_the_servo_settles_within_half_a_second_with_little_overshoot(make: MakeWorld, backend: Backend) -> None:
    world = make(make_scene(make_row(3)), make_config(backend, period_s=FINE_S))

    speed = np.array([world.advance(command(world, forward=0.5)).end.velocities[:, 0] for _ in range(20)])

    assert_allclose(speed[9:], 0.5, rtol=0.02)  # from 0.5 s on: spec section 12.2, recommended gains
    assert speed.max() <= 0.5 * 1.05
    assert speed.max() > 0.5 * 1.005  # damping 0.707 does overshoot


def test_commands_are_in_the_body_frame(make: MakeWorld) -> None:
    world = make(make_scene((make_robot(0, (0.0, 0.0), yaw=np.pi / 2.0),)))

    world.advance(command(world, forward=0.3, left=0.1))

    assert_allclose(world.advance(command(world, forward=0.3, left=0.1)).end.velocities, [(-0.1, 0.3)], atol=0.01)


def test_a_zero_command_stops_a_moving_robot(make: MakeWorld) -> None:
    world = make(make_scene(make_row(3)))
    world.advance(command(world, forward=0.5))

    world.advance(command(world))
    stopped = world.advance(command(world))

    assert_allclose(stopped.end.velocities, 0.0, atol=2e-3)
    assert_allclose(stopped.end.positions, stopped.start.positions, atol=5e-3)


def test_no_robot_accelerates_beyond_its_force_bound(make: MakeWorld, backend: Backend) -> None:
    weak = replace(THESIS_TYPES[2], force_max_n=3.0)
    world = make(make_scene((make_robot(0, (0.0, 0.0), weak),)), make_config(backend, period_s=FINE_S))
    limit = weak.force_max_n / weak.mass_kg

    first = world.advance(command(world, forward=0.5)).mean_accelerations[0]

    assert np.hypot(*first) <= limit + 1e-6
    assert np.hypot(*first) > 0.5 * limit  # and it does use the force that it has


def test_a_weak_drive_ends_at_the_speed_where_viscous_friction_balances_it(make: MakeWorld) -> None:
    weak = replace(THESIS_TYPES[0], mu2=2.0, force_max_n=0.4)  # F / b = 0.2 m/s, m / b = 0.4 s
    world = make(make_scene((make_robot(0, (-3.0, 0.0), weak),)))

    for _ in range(8):
        motion = world.advance(command(world, forward=0.5))

    assert motion.end.velocities[0, 0] == pytest.approx(0.2, rel=0.01)


def test_a_drive_that_was_saturated_for_long_stops_without_winding_down(make: MakeWorld) -> None:
    weak = replace(THESIS_TYPES[0], mu2=2.0, force_max_n=0.4)
    world = make(make_scene((make_robot(0, (-3.0, 0.0), weak),)))
    for _ in range(20):
        world.advance(command(world, forward=0.5))

    for _ in range(4):
        motion = world.advance(command(world))

    assert abs(motion.end.velocities[0, 0]) < 0.01


def test_a_robot_turns_at_the_commanded_rate_and_then_holds_its_heading(make: MakeWorld) -> None:
    world = make()

    for _ in range(4):
        turning = world.advance(command(world, turn=0.6))
    for _ in range(2):
        world.advance(command(world))
    held = world.advance(command(world))

    assert turning.end.yaw_rates[0] == pytest.approx(0.6, abs=0.01)
    assert held.end.yaws[0] == pytest.approx(4 * 0.5 * 0.6, abs=0.03)
    assert held.end.yaw_rates[0] == pytest.approx(0.0, abs=0.01)


def test_a_turning_robot_keeps_driving_along_its_own_forward_axis(make: MakeWorld) -> None:
    world = make()
    for _ in range(6):
        motion = world.advance(command(world, forward=0.3, turn=0.5))

    course = np.arctan2(motion.end.velocities[0, 1], motion.end.velocities[0, 0])

    # The velocity loop follows the turning setpoint with the lag of its dominant poles, about 0.12 s.
    assert np.hypot(*motion.end.velocities[0]) == pytest.approx(0.3, rel=0.05)
    assert course == pytest.approx(motion.end.yaws[0], abs=0.1)


def test_mean_acceleration_is_the_gain_of_velocity_over_the_period(make: MakeWorld) -> None:
    motion = make().advance(np.array([[0.4, -0.2, 0.0]]))

    assert_allclose(motion.mean_accelerations, (motion.end.velocities - motion.start.velocities) / 0.5, atol=1e-12)


@pytest.mark.parametrize("period", [0.05, 0.07, 0.5, 1.0])
def test_samples_are_dense_and_end_with_the_tick(make: MakeWorld, backend: Backend, period: float) -> None:
    world = make(config=make_config(backend, period_s=period))

    motion = world.advance(command(world, forward=0.5))

    assert len(motion.samples) >= period * SAMPLE_HZ
    assert_array_equal(motion.samples[-1], motion.end.positions)
    assert_array_equal(motion.sample_velocities[-1], motion.end.velocities)
    assert motion.end is world.state


def test_positions_follow_from_velocities(make: MakeWorld) -> None:
    world = make()
    motion = world.advance(command(world, forward=0.5))
    for _ in range(3):
        motion = world.advance(command(world, forward=0.5))

    traveled = motion.end.positions[0] - motion.start.positions[0]

    assert_allclose(traveled, (0.25, 0.0), atol=2e-3)


def test_two_worlds_of_one_seed_agree_bit_for_bit(make: MakeWorld, backend: Backend) -> None:
    rng = np.random.default_rng(5)
    scene = make_scene(make_row(6, spacing=1.1))
    first, second = (make(scene, make_config(backend, Ground.ROUGH)) for _ in range(2))

    for _ in range(6):
        setpoints = rng.uniform(-0.5, 0.5, (6, 3))
        left, right = first.advance(setpoints), second.advance(setpoints)
        assert left.samples.tobytes() == right.samples.tobytes()
        assert left.end.yaws.tobytes() == right.end.yaws.tobytes()
        assert left.end.heights.tobytes() == right.end.heights.tobytes()


def test_nobody_can_change_the_truth_from_outside(make: MakeWorld) -> None:
    world = make()
    motion = world.advance(command(world))

    for array in (world.state.positions, motion.samples, motion.end.velocities, motion.mean_accelerations):
        assert not array.flags.writeable


def test_closing_twice_is_fine_and_a_closed_world_does_not_move(make: MakeWorld) -> None:
    world = make()
    world.close()
    world.close()

    with pytest.raises(PhysicsError, match="closed"):
        world.advance(np.zeros((1, 3)))


def test_gains_that_the_step_rate_cannot_carry_are_refused(backend: Backend) -> None:
    with pytest.raises(ConfigError, match="rate_hz"):
        make_world(make_config(backend, servo=ServoConfig(gains=GainSet.TABLE_4_2)), make_scene(), seed=0)


@pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")
def test_the_back_ends_drive_the_same_course_on_free_ground() -> None:
    scene = make_scene(make_row(3))
    worlds = [make_world(make_config(backend), scene, seed=0) for backend in Backend]
    rng = np.random.default_rng(1)
    for _ in range(20):
        setpoints = np.tile(rng.uniform(-0.4, 0.4, 3), (3, 1))
        ends = [world.advance(setpoints).end for world in worlds]
    for world in worlds:
        world.close()

    assert_allclose(ends[0].positions, ends[1].positions, atol=0.03)
    assert_allclose(ends[0].yaws, ends[1].yaws, atol=0.03)
