"""A node that listens to every topic of a swarm and hands on the bytes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rclpy.node import Node

from swarm_msgs_py.ros.channels import message_type, recording_quality_of
from swarm_msgs_py.topics import Channel

NAME = "recorder"


class RecorderNode(Node):
    """Listens to channels.

    Parameters
    ----------
    channels : mapping of str to Channel
        By topic.
    take : callable
        Is handed the topic and the bytes of every message.
    **options
        Of `rclpy.node.Node`.
    """

    def __init__(self, channels: Mapping[str, Channel], take: Callable[[str, bytes], None], **options: Any) -> None:
        super().__init__(NAME, **options)
        for topic, channel in channels.items():
            kind, quality = message_type(channel.message), recording_quality_of(channel)
            self.create_subscription(kind, topic, partial(take, topic), quality, raw=True)
