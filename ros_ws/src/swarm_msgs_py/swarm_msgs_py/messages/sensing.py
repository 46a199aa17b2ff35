"""What a robot measures in one tick."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.types import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class ImuSample:
    """Inertial measurement over the last tick.

    Attributes
    ----------
    acceleration_body : (2,) array
        Mean planar acceleration over the tick, gravity removed, body frame [m/s^2].
    yaw : float
        Heading from the magnetometer [rad].
    yaw_rate : float
        Turn rate at the end of the tick [rad/s].
    """

    acceleration_body: FloatArray
    yaw: float
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
