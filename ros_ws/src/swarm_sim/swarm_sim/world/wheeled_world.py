"""Robots that go exactly where their wheels roll: planar kinematics, vectorized over robots and free of contacts.

Serves Monte Carlo and machines without a rigid-body engine. The ramp of the step motors keeps accelerations far below
the grip of the wheels, so that a free robot has no dynamics of its own; slip is part of the rolling.
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.errors import PhysicsError
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import SimConfig
from swarm_sim.firmware.omni_wheels import StepMotors, WheelSlip, apply, unmixing_matrices
from swarm_sim.firmware.velocity_servo import wrap_angle
from swarm_sim.scene import Scene
from swarm_sim.world.chassis import wheel_levers
from swarm_sim.world.drives import SLIP_STREAM
from swarm_sim.world.world import BodyState, Motion, TickGrid, frozen, motion_between


class WheeledWorld:
    """Omni-wheel robots as kinematic points with a heading; implements the `World` protocol.

    Parameters
    ----------
    config : SimConfig
    scene : Scene
        Checked scene; obstacles do not act on the bodies.
    seed : int
        Seed of the run; draws the slip of the wheels.
    """

    has_contacts = False

    def __init__(self, config: SimConfig, scene: Scene, seed: int) -> None:
        omni, robots = config.drive.omni, scene.robots
        self._grid = TickGrid.of(config.period_s, config.physics.rate_hz)
        levers = wheel_levers([robot.type for robot in robots], omni)
        self._motors = StepMotors(omni, levers, self._grid.step_s)
        self._slip = WheelSlip(omni, len(robots), self._grid.step_s, rng_for(seed, SLIP_STREAM))
        self._unmixing = unmixing_matrices(levers)
        positions = np.array([robot.position for robot in robots], dtype=np.float64)
        yaws = wrap_angle(np.array([robot.yaw for robot in robots]))
        still = np.zeros(len(robots))
        self._state = BodyState(frozen(positions), frozen(still), frozen(yaws), frozen(positions * 0.0), frozen(still))
        self._is_open = True

    @property
    def state(self) -> BodyState:
        """Return the true state now."""
        return self._state

    def advance(self, setpoints: FloatArray) -> Motion:
        """Run one control period; see `World.advance`."""
        if not self._is_open:
            raise PhysicsError("the world is closed")
        start, grid = self._state, self._grid
        place = start.positions[:, 0] + 1j * start.positions[:, 1]
        yaws, sampled = start.yaws, set(grid.sampled.tolist())
        places, speeds = [], []
        for k in range(1, grid.steps + 1):
            body = apply(self._unmixing, self._motors.advance(setpoints) * self._slip.advance())
            turn = grid.step_s * body[:, 2]
            # The heading in the middle of the step: second-order accurate on the arc of a turning robot.
            velocity = (body[:, 0] + 1j * body[:, 1]) * np.exp(1j * (yaws + turn / 2.0))
            place, yaws = place + grid.step_s * velocity, yaws + turn
            if k in sampled:
                places.append(place)
                speeds.append(velocity)
        samples, sample_velocities = _planar(places), _planar(speeds)
        end = BodyState(
            frozen(samples[-1]),
            start.heights,
            frozen(wrap_angle(yaws)),
            frozen(sample_velocities[-1]),
            frozen(body[:, 2]),
        )
        self._state = end
        return motion_between(start, end, samples, sample_velocities, grid.period_s)

    def close(self) -> None:
        """Refuse further motion; may be called again."""
        self._is_open = False


def _planar(points: list[np.ndarray[tuple[int, ...], np.dtype[np.complex128]]]) -> FloatArray:
    """Return complex numbers (m lists of n) as points (m, n, 2)."""
    stacked = np.stack(points)
    return np.stack([stacked.real, stacked.imag], axis=-1)
