"""Settings of the simulated world: physics, ground, firmware, sensors, radio."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import MarkerColor


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


class Drive(Enum):
    """What the robots move on."""

    FORCE = "force"
    """A planar force on rolling spheres, through the velocity servo (spec section 2)."""
    OMNI_WHEELS = "omni_wheels"
    """Three omni wheels with step motors (thesis section 5.1)."""


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
class OmniConfig(Config):
    """Wheels and step motors of robots with drive `omni_wheels` (thesis section 5.1; sizes are ours, erratum E37)."""

    wheel_radius_m: float = setting(0.029, "radius of an omni wheel", unit="m", above=0.0, maximum=0.1)
    lever_share: float = setting(
        0.7, "distance of the wheels from the middle, as a share of the coverage radius", above=0.0, maximum=1.0
    )
    steps_per_turn: int = setting(1600, "steps of a motor per turn of its wheel: 200 in eighths", minimum=20)
    rate_resolution_hz: float = setting(1.0, "motors turn at multiples of this step rate", unit="Hz", above=0.0)
    rate_max_hz: float = setting(1000.0, "largest step rate; 0.11 m/s at the rim", unit="Hz", above=0.0)
    rate_ramp_hzps: float = setting(
        5000.0, "largest change of a step rate per second, so that no step is lost", unit="Hz/s", above=0.0
    )
    slip_sigma: float = setting(0.02, "standard deviation of a wheel's slip", minimum=0.0, maximum=0.2)
    slip_time_s: float = setting(0.5, "how long slip remembers itself", unit="s", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveConfig(Config):
    """How commands become motion."""

    kind: Drive = setting(
        Drive.FORCE, "force: on rolling spheres, through the velocity servo; omni_wheels: three wheels, step motors"
    )
    omni: OmniConfig = section(OmniConfig, "wheels and step motors of drive omni_wheels")


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuConfig(Config):
    """Inertial measurement (thesis section 4.2)."""

    bias_max_mps2: float = setting(
        9.81e-4, "largest constant acceleration bias per axis, drawn per robot (0.1 mg)", unit="m/s^2", minimum=0.0
    )
    sigma_mps2: float = setting(0.01, "white noise of the mean acceleration", unit="m/s^2", minimum=0.0)
    yaw_sigma_rad: float = setting(0.0, "white noise of the heading", unit="rad", minimum=0.0)
    has_compass: bool = setting(True, "whether robots carry a magnetometer, which gives the heading")


@dataclass(frozen=True, slots=True, kw_only=True)
class FixConfig(Config):
    """Position sensor of the robots that carry one."""

    sigma_m: float = setting(0.02, "white noise per axis", unit="m", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class RangingConfig(Config):
    """Time-of-arrival ranging between direct radio neighbors."""

    is_on: bool = setting(True, "whether radios range at all")
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


class Renderer(Enum):
    """Who draws the images of the camera."""

    RASTER = "raster"
    """Our own: exact edges, fast, needs no engine."""
    BULLET = "bullet"
    """PyBullet's software renderer, with several samples per pixel; takes three times as long."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SpotConfig(Config):
    """A disc on the floor that belongs to no robot."""

    color: MarkerColor = setting(help="color, one of the robots'")
    center_m: tuple[float, float] = setting(help="where its middle is", unit="m")
    radius_m: float = setting(help="its radius", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraConfig(Config):
    """The camera above a table-top arena (thesis section 5.1; its optics are ours, erratum E37)."""

    is_on: bool = setting(False, "whether there is a camera")
    renderer: Renderer | None = setting(
        None, "who draws the images: bullet (PyBullet's) or raster (ours, fast); null: bullet where it is the physics"
    )
    rate_hz: float = setting(10.0, "images per second of simulated time", unit="Hz", above=0.0, maximum=60.0)
    width_px: int = setting(640, "image width", unit="pixels", minimum=160, maximum=4096)
    height_px: int = setting(480, "image height", unit="pixels", minimum=120, maximum=4096)
    elevation_m: float = setting(2.4, "height above the floor", unit="m", minimum=0.5, maximum=10.0)
    view_m: float = setting(2.3, "height of the image on the floor, without distortion", unit="m", above=0.0)
    mount_sigma_m: float = setting(
        0.03,
        "standard deviation of where it is mounted, per axis; drawn once per run",
        unit="m",
        minimum=0.0,
        maximum=0.3,
    )
    aim_sigma_m: float = setting(
        0.008,
        "standard deviation of the point of the floor that it is aimed at, per axis",
        unit="m",
        minimum=0.0,
        maximum=0.3,
    )
    roll_sigma_rad: float = setting(
        0.005, "standard deviation of how it is turned about its view", unit="rad", minimum=0.0, maximum=0.2
    )
    radial_distortion: float = setting(
        -0.06, "k1 of the lens; a fortieth of it is k2 with the opposite sign", minimum=-0.15, maximum=0.15
    )
    info_sigma: float = setting(
        0.001, "standard deviation of what its maker says of focal length and lens, relative", minimum=0.0, maximum=0.02
    )
    spot_px: float = setting(
        1.5, "side of the square that lens and sensor spread a point over", unit="pixels", minimum=1.0, maximum=4.0
    )
    light_gradient: float = setting(
        0.25, "relative change of the light from the middle to the edge of the image", minimum=0.0, maximum=0.8
    )
    vignette: float = setting(0.15, "relative loss of light in the corners of the image", minimum=0.0, maximum=0.8)
    tint_sigma: float = setting(
        0.03, "standard deviation of the gain of each color channel; drawn once per run", minimum=0.0, maximum=0.2
    )
    noise_codes: float = setting(
        2.5,
        "standard deviation of a pixel's noise; from 10 on discs are missed",
        unit="codes of 255",
        minimum=0.0,
        maximum=10.0,
    )
    off_from_s: float = setting(0.0, "when the camera fails", unit="s", minimum=0.0)
    off_for_s: float = setting(0.0, "for how long; 0: it does not fail", unit="s", minimum=0.0)
    black_from_s: float = setting(0.0, "when the left half of the image turns black", unit="s", minimum=0.0)
    black_for_s: float = setting(0.0, "for how long; 0: it does not", unit="s", minimum=0.0)
    spots: tuple[SpotConfig, ...] = setting(
        (), "discs on the floor that belong to no robot, e.g. [{color: red, center_m: [0.2, 0.1], radius_m: 0.05}]"
    )


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
    drive: DriveConfig = section(DriveConfig, "what the robots move on")
    imu: ImuConfig = section(ImuConfig, "inertial sensor")
    fix: FixConfig = section(FixConfig, "position sensor")
    ranging: RangingConfig = section(RangingConfig, "time-of-arrival ranging")
    proximity: ProximityConfig = section(ProximityConfig, "short-range sensing")
    camera: CameraConfig = section(CameraConfig, "overhead camera")
    radio: RadioConfig = section(RadioConfig, "radio medium")

    @property
    def renderer(self) -> Renderer:
        """Return who draws the images of the camera."""
        if self.camera.renderer is not None:
            return self.camera.renderer
        return Renderer.BULLET if self.physics.backend is Backend.BULLET else Renderer.RASTER
