"""The channel table: every topic of the system with its type, direction and kind of delivery, stated once.

Nodes make publishers and subscriptions from these rows (`ros.channels`); a test compares the rows with the live graph.
Nothing here needs ROS.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntFlag

from swarm_msgs_py.types import MISSION, NodeId, robot_name


class Party(Enum):
    """Who speaks or listens on a channel."""

    WORLD = "world"
    AGENT = "agent"
    MISSION = "mission computer"
    OPERATOR = "operator"
    VIEWERS = "viewers"
    EVERYONE = "everyone"


class Delivery(Enum):
    """What a channel promises."""

    EVERY_MESSAGE = "every message arrives, in order; the lockstep rests on it"
    EVERY_IMAGE = "likewise, but few are kept: they are large"
    BESIDE_IMAGE = "as many are kept as images, and the last few also reach those who come later"
    NEWEST = "the newest few messages; losing an old one does no harm"
    LATCHED = "the last message also reaches those who come later"


class Parts(IntFlag):
    """Which messages of a tick accompany a batch of radio frames; travels in the batch's flags.

    The image is of the mission computer, the others are of robots.

    Messages of one tick arrive in any order over their topics. The batch comes every tick and says what belongs to it,
    so a robot knows when it has heard everything. A part that is missing from the flags was not measured, or was empty:
    ranges come once per ranging period, and proximity when something is near or somebody beside the robot listens.
    """

    NONE = 0
    IMU = 1
    FIX = 2
    RANGES = 4
    PROXIMITY = 8
    IMAGE = 16
    NEIGHBORS = 32
    BOAT = 64


@dataclass(frozen=True, slots=True)
class Channel:
    """One topic, or one topic per node.

    Attributes
    ----------
    template : str
        Absolute name; ``{node}`` stands for the name of a robot or ``mission``.
    message : str
        Type of the messages, as ``ros2 topic info`` prints it.
    source, sink : Party
    delivery : Delivery
    """

    template: str
    message: str
    source: Party
    sink: Party
    delivery: Delivery

    @property
    def is_per_node(self) -> bool:
        """Whether each node has a topic of its own."""
        return "{node}" in self.template

    def topic(self, node: NodeId | None = None) -> str:
        """Return the absolute name of the topic, of one node where each has its own.

        Raises
        ------
        ValueError
            If the channel is per node and no node is given, or the reverse.
        """
        if self.is_per_node != (node is not None):
            raise ValueError(f"{self.template}: {'name a node' if self.is_per_node else 'there is only one topic'}")
        return self.template if node is None else self.template.format(node=namespace_of(node))


def namespace_of(node: NodeId) -> str:
    """Return the namespace of a node: ``r07``, or ``mission``."""
    return "mission" if node == MISSION else robot_name(node)


_EVERY, _NEWEST, _LATCHED = Delivery.EVERY_MESSAGE, Delivery.NEWEST, Delivery.LATCHED

IMU = Channel("/{node}/imu", "sensor_msgs/msg/Imu", Party.WORLD, Party.AGENT, _EVERY)
FIX = Channel("/{node}/fix", "geometry_msgs/msg/PoseWithCovarianceStamped", Party.WORLD, Party.AGENT, _EVERY)
RANGES = Channel("/{node}/ranges", "std_msgs/msg/Float64MultiArray", Party.WORLD, Party.AGENT, _EVERY)
PROXIMITY = Channel("/{node}/proximity", "geometry_msgs/msg/PoseArray", Party.WORLD, Party.AGENT, _EVERY)
NEIGHBORS = Channel("/{node}/neighbors", "std_msgs/msg/Float64MultiArray", Party.WORLD, Party.AGENT, _EVERY)
BOAT = Channel("/{node}/boat", "std_msgs/msg/Float64MultiArray", Party.WORLD, Party.AGENT, _EVERY)
RADIO_RX = Channel("/{node}/radio/rx", "std_msgs/msg/UInt8MultiArray", Party.WORLD, Party.AGENT, _EVERY)
RADIO_TX = Channel("/{node}/radio/tx", "std_msgs/msg/UInt8MultiArray", Party.AGENT, Party.WORLD, _EVERY)
CMD_VEL = Channel("/{node}/cmd_vel", "geometry_msgs/msg/TwistStamped", Party.AGENT, Party.WORLD, _EVERY)

ODOM = Channel("/{node}/odom", "nav_msgs/msg/Odometry", Party.AGENT, Party.VIEWERS, _NEWEST)
PATH = Channel("/{node}/path", "nav_msgs/msg/Path", Party.AGENT, Party.VIEWERS, _NEWEST)
STATUS = Channel("/{node}/status", "diagnostic_msgs/msg/DiagnosticArray", Party.AGENT, Party.VIEWERS, _NEWEST)

SHAPE = Channel("/mission/shape", "geometry_msgs/msg/PolygonStamped", Party.OPERATOR, Party.MISSION, _EVERY)
GOALS = Channel("/mission/goals", "geometry_msgs/msg/PoseArray", Party.MISSION, Party.VIEWERS, _LATCHED)
CAMERA_IMAGE = Channel(
    "/world/camera/image_raw", "sensor_msgs/msg/Image", Party.WORLD, Party.MISSION, Delivery.EVERY_IMAGE
)
CAMERA_INFO = Channel(
    "/world/camera/camera_info", "sensor_msgs/msg/CameraInfo", Party.WORLD, Party.MISSION, Delivery.BESIDE_IMAGE
)
"""One with each image, of the same stamp and frame, as tools of ROS expect it."""
CAMERA_VIEW = Channel("/mission/camera/annotated", "sensor_msgs/msg/Image", Party.MISSION, Party.VIEWERS, _NEWEST)
MARKERS = Channel("/viz/markers", "visualization_msgs/msg/MarkerArray", Party.MISSION, Party.VIEWERS, _LATCHED)

CLOCK = Channel("/clock", "rosgraph_msgs/msg/Clock", Party.WORLD, Party.EVERYONE, _NEWEST)
ROBOT_MARKERS = Channel("/viz/robots", "visualization_msgs/msg/MarkerArray", Party.WORLD, Party.VIEWERS, _NEWEST)
TRUTH = Channel("/world/truth", "geometry_msgs/msg/PoseArray", Party.WORLD, Party.VIEWERS, _NEWEST)
KILL_ROBOT = Channel("/world/kill_robot", "std_msgs/msg/UInt16", Party.OPERATOR, Party.WORLD, _EVERY)

ROBOT_SENSORS = (IMU, FIX, RANGES, PROXIMITY, RADIO_RX)
"""What the world sends to each robot of the formation family."""

POINT_SENSORS = (FIX, NEIGHBORS, RADIO_RX)
"""What the world sends to each robot of the coverage family."""

BOAT_SENSORS = (BOAT, RADIO_RX)
"""What the world sends to each robot of the assembly family."""

ROBOT_ANSWERS = (CMD_VEL, RADIO_TX)
"""What each robot sends to the world."""

ROBOT_VIEWS = (ODOM, PATH, STATUS)
"""What each robot shows to viewers."""

ROBOT_CHANNELS = (*ROBOT_SENSORS, *ROBOT_ANSWERS, *ROBOT_VIEWS)
"""All topics in the namespace of a robot."""

MISSION_CHANNELS = (RADIO_RX, RADIO_TX)
"""Per-node topics of the mission computer."""

SINGLE_CHANNELS = (CLOCK, SHAPE, GOALS, MARKERS, ROBOT_MARKERS, TRUTH, KILL_ROBOT)
"""Topics that exist once."""

CAMERA_CHANNELS = (CAMERA_IMAGE, CAMERA_INFO, CAMERA_VIEW)
"""Topics that exist once where there is an overhead camera."""

PAUSE_SERVICE = "/world/pause"
"""``std_srvs/srv/Trigger``: hold simulated time."""

RESUME_SERVICE = "/world/resume"
"""``std_srvs/srv/Trigger``: let simulated time go on."""


def power_service(robot: NodeId) -> str:
    """Return the name of the ``std_srvs/srv/SetBool`` that kills a robot (false), or switches it on (true)."""
    return f"/world/power/{robot_name(robot)}"


def channels_by_topic(
    robots: tuple[NodeId, ...],
    sensors: tuple[Channel, ...] = ROBOT_SENSORS,
    shown: tuple[Channel, ...] = ROBOT_VIEWS,
    *,
    has_camera: bool = False,
) -> dict[str, Channel]:
    """Return the channel of every topic of a swarm, by name; of robots with these sensors, showing that to viewers."""
    channels = (*sensors, *ROBOT_ANSWERS, *shown)
    table = {channel.topic(robot): channel for robot in robots for channel in channels}
    table |= {channel.topic(MISSION): channel for channel in MISSION_CHANNELS}
    singles = (*SINGLE_CHANNELS, *CAMERA_CHANNELS) if has_camera else SINGLE_CHANNELS
    return table | {channel.topic(): channel for channel in singles}


def all_topics(
    robots: tuple[NodeId, ...], sensors: tuple[Channel, ...] = ROBOT_SENSORS, *, has_camera: bool = False
) -> dict[str, str]:
    """Return the type of every topic of a swarm, by name; of robots with these sensors."""
    table = channels_by_topic(robots, sensors, has_camera=has_camera)
    return {topic: channel.message for topic, channel in table.items()}
