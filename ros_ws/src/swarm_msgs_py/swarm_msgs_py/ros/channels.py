"""Publishers and subscriptions from the channel table; quality of service is decided here and nowhere else."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any, TypeVar

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.subscription import Subscription
from rclpy.type_support import check_for_type_support
from rclpy.utilities import get_rmw_implementation_identifier

from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.ros.cdr import MessageError, is_little_endian
from swarm_msgs_py.topics import CAMERA_CHANNELS, MISSION_CHANNELS, ROBOT_CHANNELS, SINGLE_CHANNELS, Channel, Delivery
from swarm_msgs_py.types import NodeId

T = TypeVar("T")

LOCKSTEP_DEPTH = 200
"""Messages kept per topic. Lockstep needs two; a node that stalls in real time may fall this many ticks back."""

IMAGE_DEPTH = 3
"""The same for images, of which 200 would take a computer's memory."""

VIEWER_DEPTH = 100
"""The same for viewers: a recorder that is some ticks behind loses nothing, and one that keeps up costs nothing."""

DROP_LOG_PERIOD_S = 5.0  # a flood of bad messages must not become a flood of log lines

_OWN_TYPES = (
    "rcl_interfaces/msg/ParameterEvent",
    "rcl_interfaces/msg/Log",
    *(f"rcl_interfaces/srv/{verb}Parameters" for verb in ("Describe", "Get", "List", "Set")),
    "rcl_interfaces/srv/GetParameterTypes",
    "rcl_interfaces/srv/SetParametersAtomically",
    "type_description_interfaces/srv/GetTypeDescription",
    "std_srvs/srv/SetBool",
    "std_srvs/srv/Trigger",
)
"""What nodes use apart from the channels."""

_PROFILES = {
    Delivery.EVERY_MESSAGE: QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=LOCKSTEP_DEPTH
    ),
    Delivery.EVERY_IMAGE: QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=IMAGE_DEPTH
    ),
    Delivery.BESIDE_IMAGE: QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        history=HistoryPolicy.KEEP_LAST,
        depth=IMAGE_DEPTH,
    ),
    Delivery.NEWEST: QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=VIEWER_DEPTH
    ),
    Delivery.LATCHED: QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        history=HistoryPolicy.KEEP_LAST,
        depth=1,
    ),
}


def quality_of(channel: Channel) -> QoSProfile:
    """Return the quality of service of a channel."""
    return _PROFILES[channel.delivery]


def recording_quality_of(channel: Channel) -> QoSProfile:
    """Return the quality of service with which a recorder listens to a channel: nothing may be lost."""
    offered = quality_of(channel)
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE, durability=offered.durability, history=HistoryPolicy.KEEP_ALL
    )


@cache
def message_type(name: str) -> Any:
    """Return the class of a message, or service, from a name like ``sensor_msgs/msg/Imu``."""
    package, kind, message = name.split("/")
    return getattr(import_module(f"{package}.{kind}"), message)


def preload() -> None:
    """Load, without starting ROS, what nodes would load when they make their topics, parameters and services.

    It takes a process a quarter of a second; children that are forked afterwards have it already.
    """
    get_rmw_implementation_identifier()
    for channel in (*ROBOT_CHANNELS, *MISSION_CHANNELS, *SINGLE_CHANNELS, *CAMERA_CHANNELS):
        check_for_type_support(message_type(channel.message))
    for name in _OWN_TYPES:
        check_for_type_support(message_type(name))


def publisher(node: Node, channel: Channel, address: NodeId | None = None) -> Publisher:
    """Return a publisher on a channel; it takes messages, and serialized messages as bytes."""
    return node.create_publisher(message_type(channel.message), channel.topic(address), quality_of(channel))


def subscription(
    node: Node, channel: Channel, take: Callable[[Any], None], address: NodeId | None = None
) -> Subscription:
    """Let `take` be called with every message of a channel."""
    kind = message_type(channel.message)
    return node.create_subscription(kind, channel.topic(address), take, quality_of(channel))


def decoded_subscription(
    node: Node,
    channel: Channel,
    decode: Callable[[bytes], T],
    take: Callable[[T], None],
    address: NodeId | None = None,
) -> Subscription:
    """Let `take` be called with every message of a channel as a typed record.

    A message that `decode` refuses is dropped and logged: what others put on a topic must not stop a node.

    Parameters
    ----------
    decode : callable
        Makes the record of the serialized message; raises `MessageError` or `FrameError` if it cannot.
    """
    kind, topic, logger = message_type(channel.message), channel.topic(address), node.get_logger()

    def receive(data: bytes) -> None:
        if not is_little_endian(data):
            data = serialize_message(deserialize_message(data, kind))
        try:
            record = decode(data)
        except (MessageError, FrameError) as error:
            logger.warning(f"{topic}: message dropped: {error}", throttle_duration_sec=DROP_LOG_PERIOD_S)
            return
        take(record)

    return node.create_subscription(kind, topic, receive, quality_of(channel), raw=True)
