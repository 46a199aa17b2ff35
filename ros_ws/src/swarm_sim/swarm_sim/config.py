"""Settings of the simulated world: physics, ground, firmware, sensors, radio."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError


class Backend(Enum):
    """Who moves the bodies."""

    BULLET = "bullet"
    MASSDAMPER = "massdamper"


class Ground(Enum):
    """What the robots drive on."""

    ROUGH = "rough"
    PLANE = "plane"


class GainSet(Enum):
    """Where the gains of the velocity servo come from (spec section 12.2, erratum E20)."""

    RECOMMENDED = "recommended"
    TABLE_4_2 = "table_4_2"
    WEIGHTS = "weights"


class RangingModel(Enum):
    """What is noisy about measured ranges (spec section 4, erratum E11)."""

    RANGE = "range"
    """Each range has its own error, as ranging radios have."""
    POSITION = "position"
    """All ranges of a robot are taken from one wrong point, as in the simulations of the thesis."""


class RadioModel(Enum):
    """Who hears whom."""

    LINE_OF_SIGHT = "line_of_sight"
    """Who is in range, with no obstacle between (spec section 3)."""
    IDEAL = "ideal"
    """Everybody hears everybody, as in the thesis' comparison of methods."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PhysicsConfig(Config):
    """The physics back end."""

    backend: Backend = setting(
        Backend.BULLET, "bullet: rigid bodies with contacts; massdamper: m dv/dt = F - b v, fast"
    )
    rate_hz: float = setting(
        60.0,
        "physics steps per second, also the rate of the robots' firmware (table_4_2 gains need 80 Hz)",
        unit="Hz",
        minimum=50.0,
        maximum=2000.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainConfig(Config):
    """The ground of the arena (back end `bullet`; `massdamper` is flat)."""

    ground: Ground = setting(Ground.ROUGH, "rough: seeded height field; plane: flat")
    amplitude_m: float = setting(0.10, "standard deviation of the ground height", unit="m", minimum=0.0, maximum=0.5)
    roughness: float = setting(0.3, "0: only long waves; 1: short waves as high as long ones", minimum=0.0, maximum=1.0)
    wavelength_m: float = setting(12.0, "longest wave of the ground", unit="m", minimum=4.0, maximum=100.0)
    margin_m: float = setting(20.0, "ground beyond the bounds of the arena", unit="m", minimum=2.0, maximum=200.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoConfig(Config):
    """The velocity servo in the robots' firmware."""

    gains: GainSet = setting(GainSet.RECOMMENDED, "recommended, table_4_2 or weights (thesis eq. (3.108)-(3.111))")
    command_hold_s: float = setting(
        0.0, "how long a command holds beyond the tick it was made for; 0 keeps collision avoidance safe when a robot "
        "falls silent, since neighbors count on no more than one tick of motion", unit="s", minimum=0.0,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuConfig(Config):
    """Inertial measurement (thesis section 4.2)."""

    bias_max_mps2: float = setting(
        9.81e-4, "largest constant acceleration bias per axis, drawn per robot (0.1 mg)", unit="m/s^2", minimum=0.0
    )
    sigma_mps2: float = setting(0.01, "white noise of the mean acceleration", unit="m/s^2", minimum=0.0)
    yaw_sigma_rad: float = setting(0.0, "white noise of the heading", unit="rad", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class FixConfig(Config):
    """Position sensor of the robots that carry one."""

    sigma_m: float = setting(0.02, "white noise per axis", unit="m", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class RangingConfig(Config):
    """Time-of-arrival ranging between direct radio neighbors."""

    model: RangingModel | None = setting(
        None,
        "range: white noise on each range; position: thesis section 4.2, noise on the point that a robot ranges from, "
        "so that the geometry of the beacons has no effect; not set: position if the robots localize themselves as in "
        "the thesis (agent.lps.mode literal), else range",
    )
    sigma_m: float = setting(
        2.0, "white noise of each range, or of the point per axis (thesis: 2 m)", unit="m", minimum=0.0
    )
    period_s: float | None = setting(
        None,
        "time between two rounds of ranging, in which all robots range; up to the control period: every tick; not set: "
        "as often as the robots localize themselves (agent.lps.period_s)",
        unit="s",
        minimum=0.0,
        maximum=600.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ProximityConfig(Config):
    """Short-range relative sensing of robots and walls."""

    range_m: float = setting(3.0, "farthest surface that is seen, from the robot's center", unit="m", minimum=0.0)
    sigma_m: float = setting(0.005, "white noise per axis of each point", unit="m", minimum=0.0)
    points_max: int = setting(12, "nearest points that are reported", minimum=1, maximum=1000)


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioConfig(Config):
    """The radio medium (spec section 3)."""

    model: RadioModel = setting(
        RadioModel.LINE_OF_SIGHT,
        "line_of_sight: in range, with no obstacle between; ideal: everybody hears everybody (range_m has no effect)",
    )
    range_m: float = setting(25.0, "radios closer than this and in line of sight hear each other", unit="m", above=0.0)
    loss: float = setting(0.0, "probability that one receiver misses one frame", minimum=0.0, maximum=1.0)
    delay_ticks_max: int = setting(0, "largest extra delay of a frame, drawn per receiver", unit="ticks", minimum=0)
    budget_bps: float = setting(
        250_000.0, "bit rate of one radio; what a tick has no time for goes on in the next", unit="bit/s", above=0.0
    )
    queue_s: float = setting(
        0.5, "a frame that would wait longer than this for its turn is dropped", unit="s", minimum=0.0, maximum=60.0
    )

    def __post_init__(self) -> None:
        """Check that what is ideal loses and delays nothing; nobody would send it again.

        Raises
        ------
        ConfigError
        """
        Config.__post_init__(self)
        if self.model is RadioModel.IDEAL and (self.loss > 0.0 or self.delay_ticks_max > 0):
            raise ConfigError("model ideal loses and delays nothing; set loss and delay_ticks_max to 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class SimConfig(Config):
    """All settings of the simulated world."""

    period_s: float = setting(0.5, "control period: one tick", unit="s", minimum=0.05, maximum=1.0)
    physics: PhysicsConfig = section(PhysicsConfig, "back end and rate")
    terrain: TerrainConfig = section(TerrainConfig, "the ground")
    servo: ServoConfig = section(ServoConfig, "velocity servo")
    imu: ImuConfig = section(ImuConfig, "inertial sensor")
    fix: FixConfig = section(FixConfig, "position sensor")
    ranging: RangingConfig = section(RangingConfig, "time-of-arrival ranging")
    proximity: ProximityConfig = section(ProximityConfig, "short-range sensing")
    radio: RadioConfig = section(RadioConfig, "radio medium")
