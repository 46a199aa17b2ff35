"""The command line of ``replay.py``: a recording onto live topics."""

from __future__ import annotations

import argparse
import importlib.util
import math
import os
import sys
import time
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from bringup.domain_guard import DomainGuard, domain_of
from bringup.option_types import OneLineParser, complain, number
from recording.bag import BagReader, BagTopic, opened
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_msgs_py.topics import SINGLE_CHANNELS, Party

OK, BAD_INPUT, INTERRUPTED = 0, 2, 130
ORDERS = frozenset(channel.topic() for channel in SINGLE_CHANNELS if channel.source is Party.OPERATOR)
"""What an operator said; not said again unless it is asked for, since it would steer whoever listens."""


def main(argv: Sequence[str] | None = None) -> int:
    """Play what the command line asks for; return the exit code (0, 2 or 130)."""
    guard: DomainGuard | None = None
    try:
        given = parse_arguments(sys.argv[1:] if argv is None else argv)
        with opened(given.bag) as bag:
            chosen = _chosen(bag, given.topic)
            if given.start > bag.duration_s:
                raise ConfigError(
                    f"--start {given.start:g}: the recording ends after {bag.duration_s:g} s; begin earlier"
                )
            if importlib.util.find_spec("rclpy") is None:
                raise ConfigError("rclpy is not installed; run `make`, or source ROS 2")
            guard = DomainGuard(domain_of(os.environ))
            guard.acquire()  # what robots once sensed must not reach robots that run now
            return _play(bag, chosen, given)
    except KeyboardInterrupt:
        return INTERRUPTED
    except SwarmError as error:
        complain(error)
        return BAD_INPUT
    finally:
        if guard is not None:
            guard.release()


def parse_arguments(argv: Sequence[str]) -> argparse.Namespace:
    """Return what is asked for.

    Raises
    ------
    ConfigError
        One line that names the option and the remedy.
    SystemExit
        With code 0, after ``--help``.
    """
    parser = OneLineParser(
        prog="replay.py",
        description="Play a recording onto ROS topics, in a domain in which no swarm runs.",
        epilog="Exit code 0: played to its end; 2: bad input; 130: interrupted.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("bag", metavar="BAG", type=Path, help="run folder made with --record, bag folder, or .mcap file")
    add("--rate", metavar="X", type=number(0.0, 1e4), default=1.0,
        help="recorded seconds per second; 0: as fast as possible (default: %(default)s)")  # fmt: skip
    add("--start", metavar="S", type=number(0.0, 1e9), default=0.0, help="begin that much after the first message")
    add("--topic", metavar="PREFIX", action="append", default=[],
        help="only topics whose names begin so, e.g. /r07/ or /clock; may be given several times "
        "(default: all but the operator's orders)")  # fmt: skip
    add("--wait", metavar="S", type=number(0.0, 1e6), default=5.0,
        help="begin once all listeners are found, or after that time without any (default: %(default)s)")  # fmt: skip
    return parser.parse_args(argv)


def _chosen(bag: BagReader, prefixes: Sequence[str]) -> tuple[BagTopic, ...]:
    """Return the topics to play.

    Raises
    ------
    ConfigError
        If there are none.
    """
    if not prefixes:
        return tuple(topic for topic in bag.topics if topic.name not in ORDERS)
    chosen = tuple(topic for topic in bag.topics if topic.name.startswith(tuple(prefixes)))
    if not chosen:
        named = ", ".join(topic.name for topic in bag.topics[:6])
        raise ConfigError(f"--topic {' '.join(prefixes)}: the recording has no such topic; it has {named}, ...")
    return chosen


def _play(bag: BagReader, chosen: tuple[BagTopic, ...], given: argparse.Namespace) -> int:
    # Imported on demand: bad input must be told where ROS is not installed.
    spin, node = import_module("swarm_msgs_py.ros.spin"), import_module("recording.ros.player_node")
    stay_local = import_module("swarm_msgs_py.ros.environment").stay_local
    stay_local(os.environ)
    with spin.started(handle_signals=False) as executor:
        player: Any = node.PlayerNode(chosen, context=executor.context, **spin.LEAN)
        executor.add_node(player)

        def spin_for(duration_s: float) -> None:
            end = time.monotonic() + duration_s
            while (left := end - time.monotonic()) > 0.0:
                spin.spin_for(executor, min(left, spin.SLICE_S))  # in slices, so that Ctrl-C is heard

        names = frozenset(topic.name for topic in chosen)
        cut = "; unfinished: cut off there, its recorder was killed" if bag.is_unfinished else ""
        print(f"{given.bag}: {len(names)} topics, {bag.duration_s:g} s{cut}", flush=True)
        if not player.await_listeners(given.wait, spin_for):
            print("nobody listens yet", flush=True)
        count = player.play(bag.messages(names, given.start), node.Pace(given.rate or math.inf), spin_for)
        player.await_acknowledgment()
        print(f"{count} messages played", flush=True)
    return OK
