from __future__ import annotations

from dataclasses import replace

import numpy as np
from arena import make_config, make_robot, make_scene
from numpy.testing import assert_allclose

from swarm_msgs_py.robots import THESIS_TYPES
from swarm_sim.config import GainSet
from swarm_sim.firmware.servo_gains import servo_gains
from swarm_sim.firmware.velocity_servo import VelocityServo, held_force_response
from swarm_sim.world.massdamper_world import MassDamperWorld


def test_the_one_product_per_tick_equals_stepping() -> None:
    kinds = (*THESIS_TYPES, replace(THESIS_TYPES[2], force_max_n=3.0))  # the last one saturates and is stepped
    world = MassDamperWorld(
        make_config(), make_scene([make_robot(i, (2.0 * i, 0.0), kind) for i, kind in enumerate(kinds)])
    )
    steps, step_s = 30, 1.0 / 60.0
    servo = VelocityServo(servo_gains(kinds, GainSet.RECOMMENDED), kinds, step_s)
    decay, gain, glide, shift = np.array([held_force_response(kind, step_s) for kind in kinds]).T[:, :, None]
    x, v = world.state.positions.copy(), np.zeros((4, 2))
    rng = np.random.default_rng(2)

    saturated = False
    for _ in range(12):
        setpoints = np.column_stack([rng.uniform(-0.5, 0.5, (4, 2)), np.zeros(4)])
        motion = world.advance(setpoints)
        for _ in range(steps):
            force = servo.force(setpoints[:, :2], v)
            saturated |= bool(np.isclose(np.hypot(*force[3]), 3.0))
            x, v = x + glide * v + shift * force, decay * v + gain * force

        assert_allclose(motion.end.positions, x, atol=1e-10)
        assert_allclose(motion.end.velocities, v, atol=1e-10)
    assert saturated


def test_robots_that_turn_do_not_change_the_course_of_those_that_do_not() -> None:
    scene = make_scene([make_robot(0, (0.0, 0.0)), make_robot(1, (3.0, 0.0))])
    alone, together = MassDamperWorld(make_config(), scene), MassDamperWorld(make_config(), scene)
    for _ in range(4):
        straight = alone.advance(np.array([[0.3, 0.1, 0.0], [0.0, 0.0, 0.0]]))
        mixed = together.advance(np.array([[0.3, 0.1, 0.0], [0.2, 0.0, 0.8]]))

    assert_allclose(mixed.end.positions[0], straight.end.positions[0], atol=1e-12)
