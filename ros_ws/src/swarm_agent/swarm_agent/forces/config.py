"""Settings of the artificial forces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError

_WAY_PER_TICK = 0.5  # share of the way to where a robot is wanted


class ForceLawName(Enum):
    """Force laws."""

    LITERAL = "forces-literal"
    """The five forces of thesis section 3.2.1."""
    SHARING = "forces"
    """Own variant: every robot is drawn to the middle of its share of the shape."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiteralForceConfig(Config):
    """Gains of the thesis' forces (section 4.3), with the readings of its sums that spec section 8.2 settles on."""

    attractive_gain: float = setting(250.0, "k_a, to the boundary center from outside (thesis 4.3)", minimum=0.0)
    repulsive_gain: float = setting(150.0, "k_r, away from the contour inside (thesis 4.3)", minimum=0.0)
    intermember_gain: float = setting(1500.0, "k_m, away from other robots (thesis 4.3)", minimum=0.0)
    transition_gain: float = setting(1000.0, "k_t, to the contour from outside (thesis 4.3)", minimum=0.0)
    obstacle_gain: float = setting(5000.0, "k_o, away from obstacles (thesis 4.3)", minimum=0.0)
    buffer_m: float = setting(
        1.0, "width of the band inside the contour in which inner and outer forces blend (spec 8.3)", unit="m", above=0
    )
    robot_gap_min_m: float = setting(
        0.05, "nearer robots push as if this far away: the law is singular at contact (spec E5)", unit="m", above=0.0
    )
    obstacle_gap_min_m: float = setting(0.1, "nearer obstacles push as if this far away (E5)", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SharingForceConfig(Config):
    """Tuning of the own variant."""

    gain_1_s: float = setting(1.0, "speed per meter to the middle of the own share", unit="1/s", above=0.0, maximum=2.0)
    range: float = setting(
        0.5, "how far a robot looks for its share, in square roots of the shape's area", above=0.0, maximum=10.0
    )
    samples: int = setting(1500, "points of the shape that the shares consist of", minimum=100, maximum=100_000)
    spread_gain: float = setting(
        1.0, "of the way from the mean of the robots to that of the room: evens out the density", minimum=0.0, maximum=4
    )
    spread_slack: float = setting(
        0.05, "how long that way may be in an even mesh, in square roots of the share's area", minimum=0.0, maximum=1.0
    )
    inset: float = setting(
        0.02,
        "gap kept between coverage circle and contour, in square roots of the shape's area",
        minimum=0.0,
        maximum=1,
    )
    personal_gap_m: float = setting(
        0.6, "range of the intermember force: free gap at which it ends, if there is room", unit="m", above=0.0
    )
    personal_share: float = setting(
        0.6, "that range is at most this share of the free gap in an even mesh", above=0.0, maximum=1.0
    )
    firmness: float = setting(
        3.0, "intermember force at contact, and half of the obstacle force there, in units of f_sat", minimum=0.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceConfig(Config):
    """Method A: how forces become a velocity, and the tuning of both laws; which of them acts, the plan says."""

    speed_max_m_s: float = setting(0.5, "speed under a force of f_sat or more (thesis 4.3)", unit="m/s", above=0.0)
    f_sat: float = setting(1500.0, "force of full speed, in the units of the thesis' gains (spec 8.2)", above=0.0)
    substep_s: float = setting(
        0.1,
        "the literal law is stiff below gaps of 1 m: longest step of the robot's own prediction (spec 8.2: 10 Hz)",
        unit="s",
        above=0.0,
        maximum=1.0,
    )
    rest_m_s: float = setting(0.03, "a robot that is driven slower than this stops", unit="m/s", minimum=0.0)
    wake_m_s: float = setting(0.1, "a robot at rest that is driven faster than this starts again", unit="m/s", above=0)
    literal: LiteralForceConfig = section(LiteralForceConfig, "gains of the thesis' law")
    sharing: SharingForceConfig = section(SharingForceConfig, "tuning of the own variant")

    foresight_s: float = setting(
        2.0,
        "while the shape moves, forces see it as it will be so much later: they move robots about as far behind it",
        unit="s",
        minimum=0.0,
    )

    def __post_init__(self) -> None:
        """Check that rest has hysteresis."""
        Config.__post_init__(self)
        if self.wake_m_s <= self.rest_m_s:
            raise ConfigError(f"wake_m_s must be > rest_m_s ({self.rest_m_s:g} m/s), got {self.wake_m_s:g}")

    def at_period(self, period_s: float) -> ForceConfig:
        """Return the settings for a control period [s]: who hears of the others later has to answer more softly.

        Robots that each go all of their way in a tick, toward places that follow from where the others were a tick ago,
        never come to rest. Half of the way is what a swarm bears.
        """
        gain = min(self.sharing.gain_1_s, _WAY_PER_TICK / period_s)
        return replace(self, sharing=replace(self.sharing, gain_1_s=gain))
