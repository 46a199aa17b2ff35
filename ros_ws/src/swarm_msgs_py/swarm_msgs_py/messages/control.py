"""What a robot's decision layer asks of its firmware."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """Velocity setpoint in the body frame, as on ``cmd_vel``.

    Attributes
    ----------
    forward, left : float
        Linear velocity, body frame [m/s].
    yaw_rate : float
        Turn rate, counter-clockwise positive [rad/s].
    """

    forward: float
    left: float
    yaw_rate: float = 0.0


STOP = VelocityCommand(0.0, 0.0, 0.0)
