"""How a drive pushes a rigid body: the force servo of robots on spheres, and the traction of wheels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import Drive, DriveConfig, SimConfig
from swarm_sim.firmware.omni_wheels import StepMotors, WheelSlip, apply, mixing_matrices, unmixing_matrices
from swarm_sim.firmware.servo_gains import servo_gains
from swarm_sim.firmware.velocity_servo import HeadingServo, VelocityServo
from swarm_sim.gravity import GRAVITY
from swarm_sim.world.chassis import Chassis, wheel_levers

WHEELS = 3
SLIP_STREAM = "wheel slip"


class DriveTrain(Protocol):
    """What turns commands into forces on the bodies; one call per physics step."""

    def push(
        self, setpoints: FloatArray, velocities: FloatArray, yaws: FloatArray, yaw_rates: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return forces (n, 2) in the world frame [N] and torques (n,) [N m], to be held over the next step.

        Parameters
        ----------
        setpoints : (n, 3) array
            Forward and left velocity, body frame [m/s], and turn rate [rad/s].
        velocities : (n, 2) array
            World frame [m/s].
        yaws, yaw_rates : (n,) array
            [rad], [rad/s].
        """
        ...


def make_drive(config: SimConfig, types: Sequence[RobotType], yaws: FloatArray, step_s: float, seed: int) -> DriveTrain:
    """Return the configured drives of robots that start with headings `yaws` (n,) [rad].

    Raises
    ------
    ConfigError
        If a servo loop would be unstable at this step.
    """
    if config.drive.kind is Drive.OMNI_WHEELS:
        return WheelDrive(config.drive, types, step_s, seed)
    servo = VelocityServo(servo_gains(types, config.servo.gains), types, step_s)
    return ForceDrive(types, servo, HeadingServo(yaws, step_s))


class ForceDrive:
    """A planar force through the velocity servo, against rolling resistance ``b v``."""

    def __init__(self, types: Sequence[RobotType], servo: VelocityServo, heading: HeadingServo) -> None:
        self._servo, self._heading = servo, heading
        self._friction = np.array([[robot_type.mu2] for robot_type in types])
        self._turning_inertia = np.array([Chassis.of(robot_type).inertia[2] for robot_type in types])

    def push(
        self, setpoints: FloatArray, velocities: FloatArray, yaws: FloatArray, yaw_rates: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return forces and torques; see `DriveTrain.push`."""
        drive = setpoints[:, 0] + 1j * setpoints[:, 1]  # a complex number turns with one product
        wanted = (drive * np.exp(1j * yaws)).view(np.float64).reshape(-1, 2)
        forces = self._servo.force(wanted, velocities) - self._friction * velocities
        return forces, self._turning_inertia * self._heading.acceleration(setpoints[:, 2], yaws, yaw_rates)


class WheelDrive:
    """Step motors that turn wheels, which pull the body along as far as they grip.

    The rims impose a velocity; the force that gives it to the body within one step is shared by the wheels, and each
    wheel's share ends at Coulomb friction, ``mu1 m g / 3``. So a robot that is held, or that stands and is pushed,
    slides on its wheels.

    Parameters
    ----------
    config : DriveConfig
    types : sequence of RobotType
        Masses, grip (mu1) and radii.
    step_s : float
        Length of a physics step [s].
    seed : int
        Seed of the run.
    """

    def __init__(self, config: DriveConfig, types: Sequence[RobotType], step_s: float, seed: int) -> None:
        levers = wheel_levers(types, config.omni)
        self._motors = StepMotors(config.omni, levers, step_s)
        self._slip = WheelSlip(config.omni, len(types), step_s, rng_for(seed, SLIP_STREAM))
        self._mixing, self._unmixing = mixing_matrices(levers), unmixing_matrices(levers)
        masses = np.array([robot_type.mass_kg for robot_type in types])
        inertias = np.array([Chassis.of(robot_type, config).inertia[2] for robot_type in types])
        self._momentum_rate = np.column_stack([masses, masses, inertias]) / step_s
        grips = np.array([robot_type.mu1 for robot_type in types])
        self._grip = (grips * masses * GRAVITY / WHEELS)[:, None]

    def push(
        self, setpoints: FloatArray, velocities: FloatArray, yaws: FloatArray, yaw_rates: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return forces and torques; see `DriveTrain.push`."""
        rims = self._motors.advance(setpoints) * self._slip.advance()
        turned = np.exp(1j * yaws)
        now = velocities[:, 0] + 1j * velocities[:, 1]
        body = now * turned.conj()
        missing = apply(self._unmixing, rims) - np.column_stack([body.real, body.imag, yaw_rates])
        # Power is the same at the rims and at the body: rim forces are the inverse transpose of the mixing.
        pulls = apply(self._unmixing.transpose(0, 2, 1), self._momentum_rate * missing)
        wrench = apply(self._mixing.transpose(0, 2, 1), np.clip(pulls, -self._grip, self._grip))
        force = (wrench[:, 0] + 1j * wrench[:, 1]) * turned
        return np.column_stack([force.real, force.imag]), wrench[:, 2]
