"""Settings of path following and collision avoidance."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class AvoidanceConfig(Config):
    """Collision avoidance from short-range proximity."""

    margin_m: float = setting(
        0.04, "free gap that is never given away: sensor noise and servo overshoot live in it", unit="m", minimum=0.0
    )
    servo_delay_s: float = setting(
        0.12,
        "2 zeta / omega_n of the velocity servo: how long it coasts on the old setpoint (spec 12.2)",
        unit="s",
        minimum=0.0,
    )
    horizon_s: float = setting(4.0, "how far ahead a robot looks for what it would drive into", unit="s", above=0.0)
    passing_gap_m: float = setting(0.15, "free gap that a passing robot would like to keep", unit="m", minimum=0.0)
    body_radius_m: float = setting(
        0.3,
        "assumed radius of what the proximity sensor sees, of which it knows only the near surface",
        unit="m",
        above=0.0,
    )
    escape_speed_m_s: float = setting(
        0.2, "speed at which a robot without a wish of its own backs out of a margin, at most", unit="m/s", above=0.0
    )
    track_m: float = setting(
        0.7, "distance that what is seen may have moved in one tick and still be the same thing", unit="m", above=0.0
    )
    stuck_after_s: float = setting(
        4.0,
        "without progress for this long, a robot calls itself blocked; without motion, it tries the other side",
        unit="s",
        above=0.0,
    )
    insist_s: float = setting(
        0.0, "a blocked robot calls itself so until it has got on for this long without a break", unit="s", minimum=0.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class YieldingConfig(Config):
    """Making way for a robot that cannot get past."""

    distance_m: float = setting(1.6, "make way for blocked robots nearer than this", unit="m", above=0.0)
    displacement_max_m: float = setting(1.2, "farthest step away from the own goal", unit="m", above=0.0)
    speed_m_s: float = setting(0.3, "speed of stepping aside", unit="m/s", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlConfig(Config):
    """Velocity setpoint along the path (spec 12.1)."""

    speed_max_m_s: float = setting(0.5, "largest commanded speed (thesis 4.3)", unit="m/s", above=0.0)
    gain_1_s: float = setting(1.0, "speed per meter to the goal, close to it", unit="1/s", above=0.0, maximum=2.0)
    park_m: float = setting(0.05, "a robot this close to its goal parks", unit="m", above=0.0)
    unpark_m: float = setting(0.15, "a parked robot this far from its goal starts again", unit="m", above=0.0)
    park_drift_m_s: float = setting(
        0.02, "a robot may park at a goal that moves slower than this, and let it go on a bit", unit="m/s", minimum=0.0
    )
    heading_gain_1_s: float = setting(0.5, "turn rate per radian of heading error", unit="1/s", minimum=0.0, maximum=2)
    heading_deg: float | None = setting(
        0.0, "direction that a robot faces unless the plan orders another one; null: that of the start", unit="deg"
    )
    turn_max_rps: float = setting(10.0, "largest commanded turn rate", unit="rad/s", above=0.0)
    avoidance: AvoidanceConfig = section(AvoidanceConfig, "collision avoidance")
    yielding: YieldingConfig = section(YieldingConfig, "making way")

    def __post_init__(self) -> None:
        """Check that parking has hysteresis."""
        Config.__post_init__(self)
        if self.unpark_m <= self.park_m:
            raise ConfigError(f"unpark_m must be > park_m ({self.park_m:g} m), got {self.unpark_m:g}")
