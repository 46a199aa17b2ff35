"""Settings of the world of point robots (Table 1 of the 3D coverage paper)."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, section, setting
from swarm_sim.config import RadioConfig

LINK_M = 50.0  # r_sc in Table 1


@dataclass(frozen=True, slots=True, kw_only=True)
class SpaceRadioConfig(RadioConfig):
    """The radio medium, with the range of the paper."""

    range_m: float = setting(
        LINK_M, "r_sc: radios strictly closer than this and in line of sight hear each other", unit="m", above=0.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PointSimConfig(Config):
    """Motion, sensing and radio of point robots."""

    period_s: float = setting(1.0, "dt, control period: one tick", unit="s", minimum=0.05, maximum=1.0)
    speed_mps: float = setting(5.0, "S_i, speed limit", unit="m/s", above=0.0)
    process_sigma_m: float = setting(
        1.0, "noise per step and axis of a robot that moves (eq. (10))", unit="m", minimum=0.0
    )
    drifts: bool = setting(False, "whether that noise moves robots at rest as well")
    sight_m: float = setting(100.0, "robots within this range and in line of sight are sensed", unit="m", above=0.0)
    offset_sigma_m: float = setting(
        0.0, "noise per axis of the relative position of a robot that is sensed", unit="m", minimum=0.0
    )
    radio: SpaceRadioConfig = section(SpaceRadioConfig, "radio medium")
