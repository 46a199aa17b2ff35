"""Kinds of robots: mass, friction and size (table 4.1 of the thesis)."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotType(Config):
    """Mechanics of one type of robot, as table 4.1 gives them."""

    type: int = setting(help="type number, as goals refer to it", minimum=1, maximum=255)
    mass_kg: float = setting(help="mass", unit="kg", above=0.0)
    mu1: float = setting(help="grip coefficient of the body against walls and other robots", minimum=0.0)
    mu2: float = setting(help="viscous friction coefficient b of m dv/dt = F - b v", unit="N s/m", minimum=0.0)
    coverage_radius_m: float = setting(help="radius of the smallest circle that covers the body", unit="m", above=0.0)
    force_max_n: float = setting(8.0, "largest planar drive force (thesis bound: 3 N, see E21)", unit="N", above=0.0)


THESIS_TYPES = (
    RobotType(type=1, mass_kg=0.8, mu1=0.21, mu2=0.13, coverage_radius_m=0.15),
    RobotType(type=2, mass_kg=1.0, mu1=0.18, mu2=0.18, coverage_radius_m=0.30),
    RobotType(type=3, mass_kg=1.5, mu1=0.21, mu2=0.13, coverage_radius_m=0.50),
)
"""The three types of table 4.1."""
