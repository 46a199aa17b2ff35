"""A node that says again what a recording holds."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from recording.bag import BagTopic
from swarm_msgs_py.ros.channels import message_type

NAME = "player"
DEPTH = 100
POLL_S = 0.05
SETTLED_S = 1.0  # in which no listener comes or goes: then all topics of a new one have been found
ACKNOWLEDGED_S = 5.0  # how long, at the end, listeners have to confirm what they have heard


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast to play.

    Attributes
    ----------
    rate : float
        Recorded seconds per second; infinite for as fast as possible.
    """

    rate: float

    def due_s(self, recorded_s: float) -> float:
        """Return how long after the start a message of a time after the start is due [s]."""
        return recorded_s / self.rate


class PlayerNode(Node):
    """Speaks on the topics of a recording.

    Parameters
    ----------
    recorded : iterable of BagTopic
    **options
        Of `rclpy.node.Node`.
    """

    def __init__(self, recorded: Iterable[BagTopic], **options: Any) -> None:
        super().__init__(NAME, **options)
        self._speakers = {
            topic.name: self.create_publisher(message_type(topic.message), topic.name, _quality(topic))
            for topic in recorded
        }

    @property
    def listeners(self) -> int:
        """How many subscriptions there are to all topics together."""
        return sum(publisher.get_subscription_count() for publisher in self._speakers.values())

    def await_listeners(self, patience_s: float, spin: Callable[[float], None]) -> int:
        """Wait until somebody listens and no more come, so that none misses the beginning; return how many do.

        Parameters
        ----------
        patience_s : float
            Longest wait for the first [s].
        spin : callable
            Lets ROS work for some seconds.
        """
        began = changed = time.monotonic()
        found = self.listeners
        while time.monotonic() < (changed + SETTLED_S if found else began + patience_s):
            spin(POLL_S)
            if self.listeners != found:
                found, changed = self.listeners, time.monotonic()
        return found

    def play(self, messages: Iterable[tuple[float, str, bytes]], pace: Pace, spin: Callable[[float], None]) -> int:
        """Publish messages when they are due; return how many.

        Parameters
        ----------
        messages : iterable of (float, str, bytes)
            Time [s], topic and bytes, in order of time.
        pace : Pace
        spin : callable
            Lets ROS work for some seconds; raises what is to end the play.
        """
        count, began, first = 0, time.monotonic(), None
        for recorded_s, topic, data in messages:
            first = recorded_s if first is None else first
            wait_s = began + pace.due_s(recorded_s - first) - time.monotonic()
            if wait_s > 0.0:
                spin(wait_s)
            self._speakers[topic].publish(data)
            count += 1
        return count

    def await_acknowledgment(self) -> None:
        """Wait until listeners have got everything, a few seconds at most."""
        end = time.monotonic() + ACKNOWLEDGED_S
        for publisher in self._speakers.values():
            publisher.wait_for_all_acked(Duration(seconds=max(0.0, end - time.monotonic())))


def _quality(topic: BagTopic) -> QoSProfile:
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.is_latched else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_LAST,
        depth=1 if topic.is_latched else DEPTH,
    )
