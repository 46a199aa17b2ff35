"""Runs nodes of this process against each other, in a domain of their own, until a condition holds."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node

from swarm_msgs_py.ros.channels import message_type, quality_of
from swarm_msgs_py.ros.environment import use_loopback
from swarm_msgs_py.ros.spin import spin_for, started
from swarm_msgs_py.topics import Channel
from swarm_msgs_py.types import NodeId
from swarm_sim.ros.lockstep import TickResult

DEADLINE_S = 20.0


class RosHarness:
    """An executor in a context of its own, and a node that looks on."""

    def __init__(self, executor: Executor) -> None:
        self.executor = executor
        self.probe = self.add(Node("probe", context=executor.context))
        self._kept: list[Any] = []

    @property
    def context(self) -> Any:
        return self.executor.context

    def add(self, node: Any) -> Any:
        self.executor.add_node(node)
        return node

    def wait(self, is_true: Callable[[], bool], what: str) -> None:
        """Run callbacks until a condition holds; fail, saying what did not happen, if it does not."""
        deadline = time.monotonic() + DEADLINE_S
        while not is_true():
            assert time.monotonic() < deadline, f"{what}: not within {DEADLINE_S:g} s"
            spin_for(self.executor, 0.02)

    def listen(self, channel: Channel, node: NodeId | None = None, *, raw: bool = False) -> list[Any]:
        """Return a list that fills with the messages of a channel."""
        heard: list[Any] = []
        kind, topic = message_type(channel.message), channel.topic(node)
        subscription = self.probe.create_subscription(kind, topic, heard.append, quality_of(channel), raw=raw)
        self._kept.append(subscription)
        return heard

    def speaker(self, channel: Channel, node: NodeId | None = None) -> Any:
        """Return a publisher on a channel that somebody listens to already."""
        kind, topic = message_type(channel.message), channel.topic(node)
        publisher = self.probe.create_publisher(kind, topic, quality_of(channel))
        self.wait(lambda: publisher.get_subscription_count() > 0, f"a subscription to {topic}")
        return publisher


@contextmanager
def harness(*arguments: str) -> Iterator[RosHarness]:
    """Start ROS for one test, as the engine does: without a file that could be left behind."""
    with TemporaryDirectory() as folder:
        use_loopback(os.environ, Path(folder))
        with started([*arguments]) as executor:
            yield RosHarness(executor)


class Overseer:
    """Lets the world run for some ticks, in which some nodes are dead from the start.

    `computing` maps nodes that are known to compute to the CPU time that they use per look at them [s].
    """

    def __init__(
        self, ticks: int, dead: tuple[NodeId, ...] = (), computing: Mapping[NodeId, float] = MappingProxyType({})
    ) -> None:
        self._ticks, self._dead, self._computing = ticks, dead, computing
        self.looks: Counter[NodeId] = Counter()
        self.results: list[TickResult] = []

    def is_over(self) -> bool:
        return len(self.results) >= self._ticks

    def may_begin(self, tick: int) -> bool:
        return tick >= 0

    def fallen(self) -> tuple[NodeId, ...]:
        return self._dead

    def computing_s(self, node: NodeId) -> float | None:
        self.looks[node] += 1
        return self.looks[node] * self._computing[node] if node in self._computing else None

    def report(self, result: TickResult) -> None:
        self.results.append(result)
