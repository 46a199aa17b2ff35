"""Shape and mass of a robot's body: four contact spheres under a flat cylindrical hull (spec section 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray

SPHERE_SHARE = 0.2
"""Radius of a contact sphere, as a share of the coverage radius."""
CENTER_HEIGHT_M = 0.22
"""Height of the center of mass above level ground [m]; within the hull's band, so that pushing against something does
not topple the lightest type."""
HULL_BOTTOM_M = 0.18
HULL_TOP_M = 0.28
"""Band of height that the hull covers [m]: the same for all types, so that every robot stops every other, and so high
above the ground that the engine need not compare it with the ground's facets (a sixth of a tick)."""


@dataclass(frozen=True, slots=True, eq=False)
class Chassis:
    """The body of one type of robot, about its center of mass.

    Attributes
    ----------
    sphere_radius : float
        [m].
    spheres : (4, 3) array
        Centers of the contact spheres, body frame [m].
    hull_radius, hull_length, hull_center : float
        Vertical cylinder: radius (the coverage radius), length and height of its middle [m].
    inertia : (ixx, iyy, izz)
        Of a solid cylinder of the robot's mass [kg m^2].
    """

    sphere_radius: float
    spheres: FloatArray
    hull_radius: float
    hull_length: float
    hull_center: float
    inertia: tuple[float, float, float]

    @classmethod
    def of(cls, robot_type: RobotType) -> Chassis:
        """Return the body of a type."""
        radius, mass = robot_type.coverage_radius_m, robot_type.mass_kg
        sphere = SPHERE_SHARE * radius
        angles = np.pi / 4.0 + np.pi / 2.0 * np.arange(4)
        ring = radius - sphere  # the spheres stay inside the coverage circle
        heights = np.full(4, sphere - CENTER_HEIGHT_M)
        spheres = np.stack([ring * np.cos(angles), ring * np.sin(angles), heights], axis=1)
        length = HULL_TOP_M - HULL_BOTTOM_M
        across = mass * (3.0 * radius**2 + length**2) / 12.0
        return cls(
            sphere_radius=sphere,
            spheres=spheres,
            hull_radius=radius,
            hull_length=length,
            hull_center=(HULL_BOTTOM_M + HULL_TOP_M) / 2.0 - CENTER_HEIGHT_M,
            inertia=(across, across, mass * radius**2 / 2.0),
        )
