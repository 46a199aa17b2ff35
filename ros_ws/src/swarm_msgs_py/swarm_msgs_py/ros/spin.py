"""Running nodes: start ROS, take callbacks until asked to stop, leave cleanly."""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.ros.environment import stay_local
from swarm_msgs_py.ros.log_bridge import bridge_logging

SLICE_S = 0.2
"""Longest time for which an idle executor keeps Python from handling signals and looking at pipes [s]."""

EXIT_OK, EXIT_CRASHED, EXIT_BAD_INPUT = 0, 1, 2

LEAN = {
    "enable_rosout": False,
    "start_parameter_services": False,
    "parameter_overrides": [Parameter("start_type_description_service", value=False)],
}
"""Options of a node that is one of many: without its nine services and its log topic it starts in half the time."""


_ROS_PROCESSES: set[int] = set()
"""Numbers of the processes, this one and those it was forked from, in which ROS was started."""


def has_started() -> bool:
    """Return whether ROS was started before, here or in a process that this one was forked from.

    The middleware's threads and locks do not survive a fork: ROS that is started after one hangs.
    """
    return bool(_ROS_PROCESSES)


@contextmanager
def started(args: Sequence[str] | None = None, *, handle_signals: bool = False) -> Iterator[Executor]:
    """Start ROS in this process and hand out an executor; both end with the context.

    The events executor is the only one that carries fifty agents in lockstep (docs/results.md); of its spinning calls,
    those without a time limit never run a callback in the version at hand, so use `spin_for`.
    """
    options = SignalHandlerOptions.ALL if handle_signals else SignalHandlerOptions.NO
    context = Context()
    _ROS_PROCESSES.add(os.getpid())
    rclpy.init(args=None if args is None else list(args), context=context, signal_handler_options=options)
    executor = EventsExecutor(context=context)
    try:
        yield executor
    finally:
        for node in executor.get_nodes():
            executor.remove_node(node)
            node.destroy_node()
        executor.shutdown()
        context.try_shutdown()


def spin_for(executor: Executor, duration_s: float, done: Future | None = None) -> None:
    """Run callbacks for `duration_s`, or until `done` has its result."""
    executor.spin_until_future_complete(done if done is not None else Future(), timeout_sec=duration_s)


def spin_until(executor: Executor, is_over: Callable[[], bool]) -> None:
    """Run callbacks until `is_over`, which is asked every `SLICE_S`, or until ROS is shut down."""
    while executor.context.ok() and not is_over():
        spin_for(executor, SLICE_S)


def is_matched(
    nodes: Iterable[Node],
    needed: Callable[[str], bool],
    overheard: Callable[[str], bool] = lambda _: False,
    own: Container[str] | None = None,
) -> bool:
    """Return whether the publishers and subscriptions of some nodes have found their partners.

    Parameters
    ----------
    nodes : iterable of Node
    needed : callable
        Whether the swarm needs a topic, so that each of its ends must have a partner.
    overheard : callable
        Whether somebody beside the swarm listens to a topic, and must not miss its first message.
    own : container of str or None
        Names of the nodes that may be partners; others, such as viewers, do not stand in for them. None: all may be.
    """
    return all(
        _has_listeners(node, publisher, needed(publisher.topic_name) + overheard(publisher.topic_name), own)
        for node in nodes
        for publisher in node.publishers
    ) and all(
        subscription.get_publisher_count() > 0
        for node in nodes
        for subscription in node.subscriptions
        if needed(subscription.topic_name)
    )


def _has_listeners(node: Node, publisher: Publisher, count: int, own: Container[str] | None) -> bool:
    """Return whether a publisher has found at least so many subscriptions of nodes that count."""
    found = publisher.get_subscription_count()
    if own is None or found < count or not count:
        return bool(found >= count)
    # The middleware tells how many it has found, and who there is, but not whom of them it has found. It learns of a
    # subscription before it finds it; so if all strangers were found, the others are ours.
    listeners = node.get_subscriptions_info_by_topic(publisher.topic_name)
    strangers = sum(each.node_name not in own and _can_hear(publisher, each.qos_profile) for each in listeners)
    return bool(found - strangers >= count)


def _can_hear(publisher: Publisher, asked: QoSProfile) -> bool:
    """Return whether a publisher offers what a listener asks for.

    Not asked of ROS (`qos_check_compatible`): to it, deadlines that are infinite and such that are not set differ.
    """
    offered = publisher.qos_profile
    asks_in_vain = (
        asked.reliability == ReliabilityPolicy.RELIABLE and offered.reliability == ReliabilityPolicy.BEST_EFFORT,
        asked.durability == DurabilityPolicy.TRANSIENT_LOCAL and offered.durability == DurabilityPolicy.VOLATILE,
    )
    return not any(asks_in_vain)


def run_node(make: Callable[[Context], Node], args: Sequence[str] | None = None) -> int:
    """Run one node, as the only one of its process, until it is interrupted.

    Parameters
    ----------
    make : callable
        Makes the node in the given context; may raise `SwarmError` for settings it cannot work with.
    args : sequence of str or None
        Command line with ROS arguments; None for that of the process.

    Returns
    -------
    int
        Exit code of the process: 0 after an interrupt, 1 after a crash, 2 for bad input.
    """

    def run(executor: Executor) -> None:
        node = make(executor.context)
        bridge_logging(node)
        executor.add_node(node)
        spin_until(executor, lambda: False)

    return run_with_ros(run, args)


def run_with_ros(run: Callable[[Executor], None], args: Sequence[str] | None = None) -> int:
    """Call `run` with ROS started, and return the exit code of the process as in `run_node`."""
    stay_local(os.environ)
    try:
        with started(args, handle_signals=True) as executor:
            run(executor)
    except (KeyboardInterrupt, ExternalShutdownException):
        return EXIT_OK
    except SwarmError as error:
        get_logger("swarm").fatal(str(error))
        return EXIT_BAD_INPUT
    except Exception as error:  # noqa: BLE001 - the one place where a node's crash becomes an exit code
        get_logger("swarm").fatal(f"{type(error).__name__}: {error}")
        return EXIT_CRASHED
    return EXIT_OK
