"""What a robot believes of its own motion."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What a robot knows of its own motion.

    Attributes
    ----------
    position, velocity : (2,) array
        World frame [m], [m/s].
    covariance : (2, 2) array
        Of the position [m^2].
    yaw : float
        Heading [rad].
    shared : float
        Share of the position's variance that the neighbors' errors have in common with it, 0 to 1.
    is_corrected : bool
        A fix, or ranges to at least three beacons, were accepted in this tick.
    """

    position: FloatArray
    velocity: FloatArray
    covariance: FloatArray
    yaw: float
    shared: float = 0.0
    is_corrected: bool = False
