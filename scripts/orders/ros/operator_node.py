"""A node that says what an operator wants, once, to a swarm that it has found."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Point32, PolygonStamped
from rclpy.duration import Duration
from rclpy.executors import Executor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from swarm_msgs_py import topics
from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.ros.channels import quality_of
from swarm_msgs_py.ros.spin import SLICE_S, spin_for
from swarm_msgs_py.types import FloatArray

NAME = "operator"


class NobodyError(SwarmError):
    """There is no swarm that would take an order."""


class OperatorNode(Node):
    """Finds the swarm, and hands orders to it.

    Parameters
    ----------
    executor : Executor
        Runs this node.
    patience_s : float
        How long to look for the swarm, and to wait for its answer [s].
    **options
        Of `rclpy.node.Node`.
    """

    def __init__(self, executor: Executor, patience_s: float, **options: Any) -> None:
        super().__init__(NAME, context=executor.context, **options)
        self._executor, self._patience_s = executor, patience_s

    def order_shape(self, contour: FloatArray) -> None:
        """Publish a contour, (k, 2) [m], and wait until the mission computer has it.

        Raises
        ------
        NobodyError
        """
        publisher = self.create_publisher(PolygonStamped, topics.SHAPE.topic(), quality_of(topics.SHAPE))
        self._await(lambda: publisher.get_subscription_count() > 0, f"nobody listens on {topics.SHAPE.topic()}")
        message = PolygonStamped()
        message.polygon.points = [Point32(x=x, y=y) for x, y in contour.tolist()]
        publisher.publish(message)
        if not publisher.wait_for_all_acked(Duration(seconds=self._patience_s)):
            raise NobodyError("the mission computer did not confirm the shape; is it still there?")

    def trigger(self, service: str) -> tuple[bool, str]:
        """Call a service without arguments; return whether it did something, and what it says."""
        return self._call(service, Trigger, Trigger.Request())

    def switch(self, service: str, *, is_on: bool) -> tuple[bool, str]:
        """Call a switch; return whether it did something, and what it says."""
        return self._call(service, SetBool, SetBool.Request(data=is_on))

    def _call(self, service: str, kind: Any, request: Any) -> tuple[bool, str]:
        client = self.create_client(kind, service)
        self._await(client.service_is_ready, f"nobody offers {service}")
        reply = client.call_async(request)
        self._await(reply.done, f"{service} does not answer")
        result = reply.result()
        return bool(result.success), str(result.message)

    def _await(self, is_true: Callable[[], bool], otherwise: str) -> None:
        end = time.monotonic() + self._patience_s
        while not is_true():
            if time.monotonic() > end:
                raise NobodyError(f"{otherwise}; start a swarm that leaves you time, in the same ROS_DOMAIN_ID")
            spin_for(self._executor, SLICE_S / 4)
