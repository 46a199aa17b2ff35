"""What a robot measures in one tick."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.types import FloatArray, IntArray, NodeId


@dataclass(frozen=True, slots=True)
class ImuSample:
    """Inertial measurement over the last tick.

    Attributes
    ----------
    acceleration_body : (2,) array
        Mean planar acceleration over the tick, gravity removed, body frame [m/s^2].
    yaw : float or None
        Heading from the magnetometer [rad]; None for a robot without one.
    yaw_rate : float
        Turn rate at the end of the tick [rad/s].
    """

    acceleration_body: FloatArray
    yaw: float | None
    yaw_rate: float


@dataclass(frozen=True, slots=True)
class PositionFix:
    """Position sensor reading of a robot that carries one.

    Attributes
    ----------
    position : (2,) array
        Measured position, world frame [m].
    sigma : float
        Standard deviation per axis [m].
    """

    position: FloatArray
    sigma: float


@dataclass(frozen=True, slots=True)
class RangeScan:
    """Time-of-arrival distances to the direct radio neighbours.

    Attributes
    ----------
    neighbors : (n,) int array
        Addresses, ascending.
    ranges : (n,) array
        Distances [m].
    """

    neighbors: IntArray
    ranges: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PoseFix:
    """Where somebody else, who looks from outside, saw a robot.

    Attributes
    ----------
    robot : NodeId
    position : (2,) array
        Middle of the robot, world frame [m].
    yaw : float
        Heading in [-pi, pi] [rad]; the thesis' clockwise bearing from +y is pi/2 minus this.
    position_sigma : float
        Standard deviation per axis [m].
    yaw_sigma : float
        Standard deviation [rad].
    """

    robot: NodeId
    position: FloatArray
    yaw: float
    position_sigma: float
    yaw_sigma: float
