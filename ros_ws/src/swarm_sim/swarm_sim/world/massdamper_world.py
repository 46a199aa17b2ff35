"""The design model of the vehicle, ``m dv/dt = F - b v`` per axis, vectorized over robots and free of contacts.

Serves Monte Carlo and machines without a rigid-body engine. The force is held over a physics step, for which the model
has an exact solution. As long as no force saturates and no robot turns, the closed loop of servo and vehicle is linear:
then one product with precomputed step responses gives the whole tick, and equals the step-by-step solution up to
rounding. Robots for which that does not hold are stepped.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_msgs_py.errors import PhysicsError
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray
from swarm_sim.config import SimConfig
from swarm_sim.firmware.servo_gains import servo_gains
from swarm_sim.firmware.velocity_servo import HeadingServo, VelocityServo, held_force_response, per_axis, wrap_angle
from swarm_sim.scene import Scene
from swarm_sim.world.world import BodyState, Motion, TickGrid, frozen, motion_between

AT_REST = 1e-12
"""Turn rates [rad/s] and turns within a tick [rad] below this are rounding, not motion."""


class MassDamperWorld:
    """Point masses under the velocity servo; implements the `World` protocol.

    Parameters
    ----------
    config : SimConfig
    scene : Scene
        Checked scene; obstacles do not act on the bodies.
    """

    has_contacts = False

    def __init__(self, config: SimConfig, scene: Scene) -> None:
        types = [robot.type for robot in scene.robots]
        self._grid = TickGrid.of(config.period_s, config.physics.rate_hz)
        self._servo = VelocityServo(servo_gains(types, config.servo.gains), types, self._grid.step_s)
        yaws = wrap_angle(np.array([robot.yaw for robot in scene.robots]))
        self._heading = HeadingServo(yaws, self._grid.step_s)
        responses = np.array([held_force_response(kind, self._grid.step_s) for kind in types])
        self._vehicle = np.stack([per_axis(column) for column in responses.T])  # (4, n, 2)
        self._response = _TickResponse(types, self._servo, self._grid)
        still = np.zeros(len(types))
        positions = np.array([robot.position for robot in scene.robots], dtype=np.float64)
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
        start = self._state
        yaw_path, rate_path = self._turn(setpoints[:, 2].copy())
        cos, sin = np.cos(yaw_path), np.sin(yaw_path)
        forward, left = setpoints[:, 0], setpoints[:, 1]
        wanted = np.stack([cos * forward - sin * left, sin * forward + cos * left], axis=-1)  # (steps or 1, n, 2)

        is_straight = np.ptp(yaw_path, axis=0) < AT_REST
        samples, speeds, errors, is_linear = self._response.run(start, self._servo.error, wanted[0], is_straight)
        rest = np.flatnonzero(~is_linear)
        if rest.size:
            self._step_through(rest, wanted, samples, speeds, errors)
        self._servo.error = errors
        end = BodyState(
            frozen(samples[-1]),
            start.heights,
            frozen(wrap_angle(yaw_path[-1])),
            frozen(speeds[-1]),
            frozen(rate_path[-1]),
        )
        self._state = end
        return motion_between(start, end, samples, speeds, self._grid.period_s)

    def close(self) -> None:
        """Refuse further motion; may be called again."""
        self._is_open = False

    def _turn(self, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return headings and turn rates after each step, (steps, n), or (1, n) when nobody turns."""
        yaws, yaw_rates = self._state.yaws, self._state.yaw_rates
        if not rates.any() and np.abs(yaw_rates).max() < AT_REST:
            return yaws[None], yaw_rates[None] * 0.0
        step = self._grid.step_s
        path = np.empty((2, self._grid.steps, len(yaws)))
        for k in range(self._grid.steps):
            yaw_rates = yaw_rates + step * self._heading.acceleration(rates, yaws, yaw_rates)
            yaws = yaws + step * yaw_rates
            path[0, k], path[1, k] = yaws, yaw_rates
        return path[0], path[1]

    def _step_through(
        self, rows: IntArray, wanted: FloatArray, samples: FloatArray, speeds: FloatArray, errors: FloatArray
    ) -> None:
        """Step the robots `rows` through the tick and write their rows of the results, in place."""
        servo = self._servo.subset(rows)
        decay, gain, glide, shift = self._vehicle.take(rows, axis=1)
        position, velocity = self._state.positions[rows], self._state.velocities[rows]
        setpoints = np.broadcast_to(wanted.take(rows, axis=1), (self._grid.steps, rows.size, 2))
        path = []
        for setpoint in setpoints:
            force = servo.force(setpoint, velocity)
            position = position + glide * velocity + shift * force
            velocity = decay * velocity + gain * force
            path.append((position, velocity))
        sampled = [path[step - 1] for step in self._grid.sampled.tolist()]
        samples[:, rows], speeds[:, rows] = np.stack(sampled, axis=1)
        errors[rows] = servo.error


class _TickResponse:
    """Response of the linear closed loop to its state and setpoint, over one tick.

    With ``z = [v, e, v_set]`` at the start, rows of the response give displacement and velocity at the samples, the
    force of every step, and the error integral at the end.
    """

    def __init__(self, types: Sequence[RobotType], servo: VelocityServo, grid: TickGrid) -> None:
        index = {kind: row for row, kind in enumerate(dict.fromkeys(types))}
        per_type = []
        for kind in index:
            robot = types.index(kind)
            gains = float(servo.gain_error[robot, 0]), float(servo.gain_speed[robot, 0])
            per_type.append(_response_rows(kind, gains, grid))
        self._rows = np.stack(per_type)[[index[kind] for kind in types]]  # (n, rows, 3)
        self._samples = len(grid.sampled)
        self._limit = servo.force_max**2

    def run(
        self, start: BodyState, errors: FloatArray, wanted: FloatArray, is_straight: BoolArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return samples (m, n, 2), velocities (m, n, 2), error integrals (n, 2), and where they hold (n,).

        They hold only for robots that keep their heading, `is_straight` (n,).
        """
        if not is_straight.any():
            samples, speeds = np.empty((2, self._samples, *wanted.shape))
            return samples, speeds, np.empty_like(errors), is_straight
        initial = np.stack([start.velocities, errors, wanted], axis=1)  # (n, 3, 2)
        answer = self._rows @ initial  # (n, rows, 2)
        m = self._samples
        samples = start.positions + answer[:, :m].transpose(1, 0, 2)
        speeds = answer[:, m : 2 * m].transpose(1, 0, 2).copy()
        forces = answer[:, 2 * m + 1 :]
        is_linear = (forces**2).sum(axis=2).max(axis=1) <= self._limit
        return samples, speeds, answer[:, 2 * m].copy(), is_linear & is_straight


def _response_rows(kind: RobotType, gains: tuple[float, float], grid: TickGrid) -> FloatArray:
    """Return the rows (2 m + 1 + steps, 3): displacements, velocities, final error integral, forces."""
    gain_error, gain_speed = gains
    decay, gain, glide, shift = held_force_response(kind, grid.step_s)
    # Rows over the basis [v, e, v_set] at the start of the tick, moved forward step by step.
    place, speed, error, wanted = np.zeros(3), *np.eye(3)
    places, speeds, forces = [], [], []
    for _ in range(grid.steps):
        error = error + grid.step_s * (wanted - speed)
        force = gain_error * error - gain_speed * speed
        place = place + glide * speed + shift * force
        speed = decay * speed + gain * force
        places.append(place)
        speeds.append(speed)
        forces.append(force)
    sampled = grid.sampled - 1
    return np.concatenate([np.array(places)[sampled], np.array(speeds)[sampled], error[None], np.array(forces)])
