"""Settings of the local positioning system (section ``lps`` of a scenario)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting

SIGMA_M = 2.0
"""Standard deviation of ranges, and of positions from them, of which nothing else is known (thesis section 4.2) [m]."""


class LpsMode(Enum):
    """How ranges become a position."""

    LITERAL = "literal"
    FIXES = "fixes"
    RANGE_EKF = "range_ekf"
    COOPERATIVE = "cooperative"


class LostRule(Enum):
    """When a robot counts as lost."""

    BEACONS = "beacons"
    SIGMA = "sigma"


@dataclass(frozen=True, slots=True, kw_only=True)
class LostConfig(Config):
    """When a robot is lost, and when it goes home (spec section 6)."""

    rule: LostRule | None = setting(
        None,
        "beacons: fewer than beacons_min direct neighbors are beacons, or no fix was accepted (thesis); sigma: the "
        "position is uncertain; not set: sigma in mode cooperative, beacons in the others",
    )
    review_period_s: float = setting(
        3.0, "time between two looks at the state: the localization period of the thesis", unit="s", above=0.0
    )
    beacons_min: int = setting(3, "beacons that a robot needs around it", minimum=1)
    sigma_max_m: float = setting(
        1.0, "largest standard deviation of a position that is known: 3 sigma of 3 m", unit="m", above=0.0
    )
    misses_max: int = setting(3, "bad reviews in a row after which a robot returns home", minimum=1)
    returns_min: int = setting(2, "good reviews in a row after which it takes part again", minimum=1)
    spacing_m: float = setting(3.0, "robots that returned home keep this far apart", unit="m", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class LpsConfig(Config):
    """How positions are found, what the filter believes about its sensors, and when it stops believing one."""

    mode: LpsMode = setting(
        LpsMode.COOPERATIVE,
        "literal: trilateration with position noise, as in the thesis; fixes: trilateration with range noise; "
        "range_ekf: every range to a beacon corrects the filter; cooperative: ranges to all neighbors do",
    )
    period_s: float = setting(
        0.0, "time between two localizations; up to the control period: every tick (thesis: 3)",
        unit="s", minimum=0.0, maximum=600.0,
    )  # fmt: skip
    range_sigma_m: float | None = setting(
        None, "standard deviation of a range; not set: in a scenario that of the world (sim.ranging.sigma_m), on a "
        "robot alone 2 m (thesis section 4.2)", unit="m", above=0.0,
    )  # fmt: skip
    position_noise_sigma_m: float | None = setting(
        None, "standard deviation per axis of a trilaterated position, mode literal (sigma_meas of the thesis); not "
        "set: as for ranges", unit="m", above=0.0,
    )  # fmt: skip
    covariance_inflation: float = setting(
        3.0, "factor on the covariance of neighbors that are no beacons, without what is shared (spec section 4)",
        minimum=1.0,
    )  # fmt: skip
    command_sigma_mps: float | None = setting(
        0.02, "how far, per axis, the velocity is from what the robot was told to drive, once its servo has settled; "
        "null, or in mode literal: the command says nothing", unit="m/s", above=0.0,
    )  # fmt: skip
    from_camera: bool = setting(
        False,
        "whether the robot learns from an overhead camera where it is: fixes come over the mesh, and without them the "
        "robot stands still",
    )
    turn_sigma_rps: float = setting(
        0.02, "how far the turn rate of a robot without a compass is from what it was told; wheels slip",
        unit="rad/s", minimum=0.0,
    )  # fmt: skip
    blind_after_s: float = setting(
        0.5, "with from_camera: a robot that no image has shown for this long stands still", unit="s", above=0.0
    )
    wall_sigma_m: float | None = setting(
        0.1, "how well a wall on the map agrees with what the proximity sensor sees of it; null, or in mode literal: "
        "walls say nothing", unit="m", above=0.0,
    )  # fmt: skip
    hello_age_max_s: float = setting(
        4.0, "age at which a hello says too little of where its sender is now for a range to it to be used",
        unit="s", above=0.0, maximum=60.0,
    )  # fmt: skip
    walls_after_s: float = setting(
        3.0, "time after the start in which no wall is recognized: it may be a robot that was not heard yet",
        unit="s", minimum=0.0, maximum=3600.0,
    )  # fmt: skip
    doubt_after_s: float = setting(
        5.0, "time that something must be near which no wall, robot or body explains before a robot that it blocks "
        "doubts its own position", unit="s", minimum=0.0, maximum=3600.0,
    )  # fmt: skip
    doubt_m2_per_s: float = setting(
        0.1, "how fast the variance of a doubted position grows, per axis; 0: no doubt", unit="m^2/s", minimum=0.0
    )
    doubt_sigma_max_m: float = setting(
        0.9, "standard deviation up to which it grows; at lost.sigma_max_m, a robot would be lost for an obstacle that "
        "is on no map", unit="m", above=0.0,
    )  # fmt: skip
    acceleration_sigma_mps2: float = setting(
        0.01, "standard deviation of a mean acceleration, per axis (thesis section 4.2)", unit="m/s^2", minimum=0.0
    )
    acceleration_bias_max_mps2: float = setting(
        9.8e-4, "largest accelerometer bias, 0.1 mg, per body axis (thesis section 4.2)", unit="m/s^2", minimum=0.0
    )
    yaw_sigma_rad: float = setting(
        0.01, "standard deviation of the heading; turns part of an acceleration sideways", unit="rad", minimum=0.0
    )
    push_delay_s: float = setting(
        0.12, "when in a period the velocity changes: the delay of the velocity servo, 2 zeta / omega_n (spec 12.2)",
        unit="s", minimum=0.0,
    )  # fmt: skip
    push_delay_sigma_s: float = setting(0.03, "how far that may be off", unit="s", minimum=0.0)
    initial_speed_sigma_mps: float = setting(
        0.1, "standard deviation of the velocity at the first fix, per axis; robots start at rest",
        unit="m/s", minimum=0.0,
    )  # fmt: skip
    restart_speed_sigma_mps: float = setting(
        0.5, "the same when the filter restarts in motion (top speed)", unit="m/s", minimum=0.0
    )
    restart_sigma_m: float = setting(
        5.0, "standard deviation, per axis, of what a filter that restarts without a fix may be off",
        unit="m", above=0.0,
    )  # fmt: skip
    gate_chi_square: float = setting(
        13.8, "a fix is rejected if its normalized innovation squared exceeds this (2 d.o.f., 0.999)", above=0.0
    )
    range_gate_chi_square: float = setting(10.8, "the same for one range (1 d.o.f., 0.999)", above=0.0)
    rejections_max: int = setting(
        5, "consecutive rejections after which the filter doubts itself and restarts", minimum=1
    )
    lost: LostConfig = section(LostConfig, "lost robots")

    @property
    def range_sigma(self) -> float:
        """Standard deviation of a range in force [m]."""
        return SIGMA_M if self.range_sigma_m is None else self.range_sigma_m

    @property
    def position_noise_sigma(self) -> float:
        """Standard deviation per axis of a trilaterated position in force, mode literal [m]."""
        return SIGMA_M if self.position_noise_sigma_m is None else self.position_noise_sigma_m

    @property
    def lost_rule(self) -> LostRule:
        """The rule in force."""
        if self.lost.rule is not None:
            return self.lost.rule
        return LostRule.SIGMA if self.mode is LpsMode.COOPERATIVE else LostRule.BEACONS
