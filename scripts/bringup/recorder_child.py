"""The child process that records a swarm."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bringup.link import Link
from bringup.processes import outlive_parent
from bringup.ros_children import Partners, Supervision, await_partners
from bringup.telemetry import Recorded, RecordingClosed
from recording.bag import BagWriter
from recording.ros.recorder_node import RecorderNode
from recording.taking import Taking
from swarm_msgs_py.ros.spin import LEAN, spin_for, spin_until, started
from swarm_msgs_py.topics import Channel, Party

QUIET_S = 0.1  # without a message, at the end, after which nothing is on its way any more
DRAIN_S = 1.0  # longest wait for that


def run_recorder(link: Link, path: Path, channels: Mapping[str, Channel], period_s: float) -> None:
    """Record everything that a swarm says until told to stop, or until nobody is there to tell.

    Parameters
    ----------
    link : Link
    path : Path
        Of the bag, which is made with the first message.
    channels : mapping of str to Channel
        Of the swarm's topics, by name.
    period_s : float
        Control period [s].
    """
    outlive_parent()  # long enough to finish the bag
    supervision = Supervision(link)
    writer = BagWriter(path, channels)
    taking = Taking(writer, channels, period_s)

    def take(topic: str, data: bytes) -> None:
        before = taking.tick
        taking.take(topic, data)
        if taking.tick > before:
            link.send(Recorded(taking.tick))

    heard = frozenset(topic for topic, channel in channels.items() if channel.source is not Party.OPERATOR)
    with started() as executor:
        node = RecorderNode(channels, take, context=executor.context, **LEAN)
        executor.add_node(node)
        if not await_partners(link, executor, [node], Partners(heard), supervision.is_over):
            return
        try:
            spin_until(executor, supervision.is_over)
            _drain(executor, taking)
        finally:
            writer.close()
        link.send(RecordingClosed(taking.account))  # before the node is taken down, which takes long


def _drain(executor: Any, taking: Taking) -> None:
    """Take what is still on its way."""
    end, before = time.monotonic() + DRAIN_S, -1
    while taking.account.messages > before and time.monotonic() < end:
        before = taking.account.messages
        spin_for(executor, QUIET_S)
