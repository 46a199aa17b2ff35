"""Shape and mass of a robot's body: contact spheres under a flat cylindrical hull (spec sections 2 and 15)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.markers import COVER_HEIGHT_M
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import Drive, DriveConfig, OmniConfig
from swarm_sim.firmware.omni_wheels import WHEEL_BEARINGS

SPHERE_SHARE = 0.2
"""Radius of a contact sphere, as a share of the coverage radius."""
CENTER_HEIGHT_M = 0.22
"""Height of the center of mass above level ground [m]; within the hull's band, so that pushing against something does
not topple the lightest type."""
HULL_BOTTOM_M = 0.18
HULL_TOP_M = 0.28
"""Band of height that the hull covers [m]: the same for all types, so that every robot stops every other, and so high
above the ground that the engine need not compare it with the ground's facets (a sixth of a tick)."""
OMNI_CENTER_HEIGHT_M = 0.05
OMNI_HULL_BOTTOM_M = 0.01
"""The same heights for table-top robots; the hull ends at the cover. They drive on flat floors only."""


@dataclass(frozen=True, slots=True, eq=False)
class Chassis:
    """The body of one type of robot, about its center of mass.

    Attributes
    ----------
    center_height : float
        Of the center of mass above level ground [m].
    sphere_radius : float
        [m].
    spheres : (k, 3) array
        Centers of the contact spheres, evenly spread on a circle, body frame [m].
    hull_radius, hull_length, hull_center : float
        Vertical cylinder: radius (the coverage radius), length and height of its middle [m].
    inertia : (ixx, iyy, izz)
        Of a solid cylinder of the robot's mass [kg m^2].
    """

    center_height: float
    sphere_radius: float
    spheres: FloatArray
    hull_radius: float
    hull_length: float
    hull_center: float
    inertia: tuple[float, float, float]

    @classmethod
    def of(cls, robot_type: RobotType, drive: DriveConfig | None = None) -> Chassis:
        """Return the body of a type; without a drive, that of a robot on spheres."""
        if drive is not None and drive.kind is Drive.OMNI_WHEELS:
            return cls._on_wheels(robot_type, drive.omni)
        radius = robot_type.coverage_radius_m
        sphere = SPHERE_SHARE * radius
        angles = np.pi / 4.0 + np.pi / 2.0 * np.arange(4)
        ring = radius - sphere  # the spheres stay inside the coverage circle
        heights = np.full(4, sphere - CENTER_HEIGHT_M)
        spheres = np.stack([ring * np.cos(angles), ring * np.sin(angles), heights], axis=1)
        return cls._under_hull(robot_type, CENTER_HEIGHT_M, sphere, spheres, (HULL_BOTTOM_M, HULL_TOP_M))

    @classmethod
    def _on_wheels(cls, robot_type: RobotType, omni: OmniConfig) -> Chassis:
        """Return a body that stands on a small sphere under each of its three wheels."""
        lever, height = omni.lever_share * robot_type.coverage_radius_m, OMNI_CENTER_HEIGHT_M
        sphere = min(omni.wheel_radius_m, height)
        heights = np.full(len(WHEEL_BEARINGS), sphere - height)
        spheres = np.stack([lever * np.cos(WHEEL_BEARINGS), -lever * np.sin(WHEEL_BEARINGS), heights], axis=1)
        return cls._under_hull(robot_type, height, sphere, spheres, (OMNI_HULL_BOTTOM_M, COVER_HEIGHT_M))

    @classmethod
    def _under_hull(
        cls, robot_type: RobotType, center: float, sphere: float, spheres: FloatArray, band: tuple[float, float]
    ) -> Chassis:
        """Return feet under a cylinder that fills a band of height [m]."""
        radius, mass = robot_type.coverage_radius_m, robot_type.mass_kg
        length = band[1] - band[0]
        across = mass * (3.0 * radius**2 + length**2) / 12.0
        return cls(
            center_height=center,
            sphere_radius=sphere,
            spheres=spheres,
            hull_radius=radius,
            hull_length=length,
            hull_center=(band[0] + band[1]) / 2.0 - center,
            inertia=(across, across, mass * radius**2 / 2.0),
        )


def wheel_levers(types: Sequence[RobotType], omni: OmniConfig) -> FloatArray:
    """Return the distance (n,) of the wheels from the middle of each robot [m]."""
    return omni.lever_share * np.array([robot_type.coverage_radius_m for robot_type in types])
