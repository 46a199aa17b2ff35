"""Settings of the CuBoat: hull, thrusters, magnets, water, pose sensor, controller.

The paper gives no parameters of the boat but the cell of 0.25 m and the magnets' 112 N; defaults are those of
section 2.1 of the digest, with a reason each.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting

CELL_M = 0.25
"""Edge of a grid cell, and distance of the centers of two docked boats [m] (paper)."""


class ControllerKind(Enum):
    """Who holds the pose of a boat."""

    LADRC = "ladrc"
    """Linear active disturbance rejection, gains by bandwidth."""
    LADRC_PAPER = "ladrc_paper"
    """The same law with table I of the paper."""
    PID = "pid"
    """PID with the gains of the tuning script."""
    PID_ZN = "pid_zn"
    """PID with gains by Ziegler and Nichols from the ultimate gain, as the paper has it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HullConfig(Config):
    """Square hull; surge and sway are alike, so that mass and drag are the same in every direction."""

    side_m: float = setting(
        0.245, "outer edge; the gap to the cell keeps docked hulls apart", unit="m", above=0.0, maximum=CELL_M
    )
    dry_mass_kg: float = setting(2.5, "what floats at a draft of 4 cm", unit="kg", above=0.0)
    added_mass_kg: float = setting(0.6, "water that surges or sways along, (pi/2) rho d^2 L", unit="kg", minimum=0.0)
    inertia_kgm2: float = setting(0.030, "about the vertical, added inertia included", unit="kg m^2", above=0.0)
    drag_nspm: float = setting(2.0, "linear drag in surge and sway", unit="N s/m", above=0.0)
    yaw_drag_nms: float = setting(0.05, "linear drag in yaw", unit="N m s", above=0.0)

    @property
    def mass_kg(self) -> float:
        """Mass that a force accelerates, added mass included [kg]."""
        return self.dry_mass_kg + self.added_mass_kg


@dataclass(frozen=True, slots=True, kw_only=True)
class ThrusterConfig(Config):
    """Four reversible thrusters in a plus."""

    arm_m: float = setting(0.10, "lever of each thruster about the center", unit="m", above=0.0)
    force_max_n: float = setting(1.0, "largest force of a thruster, either way", unit="N", above=0.0)
    lag_s: float = setting(0.10, "time constant of a thruster", unit="s", minimum=0.0, maximum=2.0)
    dead_band_n: float = setting(0.02, "commands below this do nothing", unit="N", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MagnetConfig(Config):
    """Permanent magnet and contact foils of an equipped side."""

    force_n: float = setting(112.0, "pull that tears a latched pair apart (paper)", unit="N", above=0.0)
    repulsion_n: float = setting(
        5.0,
        "push of sides of the same gender that touch; they are off each other's axis by a little",
        unit="N",
        minimum=0.0,
    )
    reach_m: float = setting(0.03, "faces farther apart do not feel each other", unit="m", above=0.0, maximum=0.1)
    decay_m: float = setting(0.005, "gap over which the pull falls to a sixteenth", unit="m", above=0.0)
    latch_gap_m: float = setting(0.01, "faces closer than this latch", unit="m", above=0.0)
    latch_angle_deg: float = setting(5.0, "largest angle between latching faces", unit="deg", above=0.0, maximum=45.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class WaterConfig(Config):
    """Wind and waves, as forces on a boat."""

    wind_n: float = setting(0.1, "constant force, one direction for the whole pool", unit="N", minimum=0.0)
    gust_n: float = setting(0.1, "root mean square of the gusts, each boat its own", unit="N", minimum=0.0)
    gust_yaw_nm: float = setting(0.005, "root mean square of the gusts' yaw moment", unit="N m", minimum=0.0)
    gust_s: float = setting(5.0, "correlation time of gusts (first-order noise)", unit="s", above=0.0)
    wave_n: float = setting(0.1, "root mean square of the waves' force along their way", unit="N", minimum=0.0)
    wave_yaw_nm: float = setting(0.005, "root mean square of the waves' yaw moment", unit="N m", minimum=0.0)
    wave_period_s: float = setting(1.2, "period of the highest wave", unit="s", above=0.1)


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseSensorConfig(Config):
    """Motion capture, the only source of pose (paper)."""

    sight_m: float = setting(
        0.875, "other hulls are seen this far along each axis: 3 cells (simulator of the paper)", unit="m", minimum=0.0
    )
    sigma_m: float = setting(0.001, "white noise per axis", unit="m", minimum=0.0)
    yaw_sigma_deg: float = setting(0.2, "white noise of the heading", unit="deg", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoatsConfig(Config):
    """All settings of boats in continuous space."""

    control_hz: float = setting(100.0, "rate of pose sensor and controller", unit="Hz", minimum=50.0, maximum=1000.0)
    physics_hz: float = setting(200.0, "rate of the rigid bodies (back end bullet)", unit="Hz", minimum=50.0)
    controller: ControllerKind = setting(ControllerKind.LADRC, "who holds the pose of a boat")
    hull: HullConfig = section(HullConfig, "mass and drag")
    thrusters: ThrusterConfig = section(ThrusterConfig, "thrusters")
    magnets: MagnetConfig = section(MagnetConfig, "docking mechanisms")
    water: WaterConfig = section(WaterConfig, "wind and waves")
    pose: PoseSensorConfig = section(PoseSensorConfig, "pose sensor")
