"""The command line of ``order.py``: another shape, pause, resume, robots off and on."""

from __future__ import annotations

import argparse
import importlib.util
import math
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from bringup.option_types import OneLineParser, complain, number
from mission_computer.shape import CoordinateUnit, Placement, is_drawing, placed_shape
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_msgs_py.topics import PAUSE_SERVICE, RESUME_SERVICE, power_service
from swarm_msgs_py.types import FloatArray, NodeId

DONE, REFUSED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
_TRIGGERS = {"pause": PAUSE_SERVICE, "resume": RESUME_SERVICE}
_SWITCHES = {"kill": False, "add": True}


def main(argv: Sequence[str] | None = None) -> int:
    """Give the order of the command line; return the exit code (0, 1, 2 or 130)."""
    try:
        given = parse_arguments(sys.argv[1:] if argv is None else argv)
        contour = _contour(given) if given.order == "shape" else None
        if importlib.util.find_spec("rclpy") is None:
            raise ConfigError("rclpy is not installed; run `make`, or source ROS 2")
        return _give(given, contour)
    except KeyboardInterrupt:
        return INTERRUPTED
    except SwarmError as error:
        complain(error)
        return BAD_INPUT


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
        prog="order.py",
        description="Give an order to the swarm that runs over ROS in this ROS_DOMAIN_ID.",
        epilog="Exit code 0: done; 1: the swarm refused, with its reason; 2: bad input, or no swarm; 130: interrupted.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "--wait", metavar="S", type=number(0.1, 1e4), default=10.0,
        help="look for the swarm that long (default: %(default)s)")  # fmt: skip
    orders = parser.add_subparsers(dest="order", required=True, metavar="ORDER", parser_class=OneLineParser)
    orders.add_parser("pause", help="hold simulated time")
    orders.add_parser("resume", help="let simulated time go on")
    for name, about in (("kill", "switch robots off"), ("add", "switch robots on")):
        switch = orders.add_parser(name, help=about)
        switch.add_argument("robots", metavar="ROBOT", type=_robot, nargs="+", help="number, or name as in r03")
    shape = orders.add_parser("shape", help="form another shape", allow_abbrev=False)
    add = shape.add_argument
    add("source", metavar="NAME|FILE|text:TEXT|POINTS", help="as --shape of the launcher; points as [[x, y], ...] [m]")
    add("--area", metavar="M2", type=number(1e-6, 1e9), help="of this area; drawings and texts need it")
    add("--center", metavar=("X", "Y"), type=number(-1e5, 1e5), nargs=2, help="put its center of area there [m]")
    add("--turn", metavar="DEG", type=number(-360.0, 360.0), default=0.0, help="turn it, counter-clockwise")
    add("--unit", choices=[unit.value for unit in CoordinateUnit], help="of GeoJSON: meters or degrees")
    return parser.parse_args(argv)


def _robot(text: str) -> NodeId:
    match = re.fullmatch(r"r?(\d{1,5})", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"expected a robot, as in r03 or 3, got '{text}'")
    return NodeId(int(match[1]))


def _contour(given: argparse.Namespace) -> FloatArray:
    """Return the contour to order, (k, 2) [m].

    Raises
    ------
    SwarmError
        If there is no such shape, or a drawing without a size.
    """
    center = None if given.center is None else (given.center[0], given.center[1])
    if is_drawing(given.source):
        if given.area is None:
            raise ConfigError(f"{given.source}: drawings and texts have no size; give --area, about 6 m2 per robot")
        center = center or (0.0, 0.0)
    placement = Placement(area=given.area, rotation=math.radians(given.turn), center=center)
    return placed_shape(given.source, placement, unit=None if given.unit is None else CoordinateUnit(given.unit))


def _give(given: argparse.Namespace, contour: FloatArray | None) -> int:
    # Imported on demand: bad input must be told where ROS is not installed.
    spin, nodes = import_module("swarm_msgs_py.ros.spin"), import_module("orders.ros.operator_node")
    with spin.started(handle_signals=False) as executor:
        operator: Any = nodes.OperatorNode(executor, given.wait, **spin.LEAN)
        executor.add_node(operator)
        if contour is not None:
            operator.order_shape(contour)
            print(f"shape of {len(contour)} vertices ordered; the mission computer says in an alert if it cannot be")
            return DONE
        if given.order in _TRIGGERS:
            replies = [operator.trigger(_TRIGGERS[given.order])]
        else:
            is_on = _SWITCHES[given.order]
            replies = [operator.switch(power_service(robot), is_on=is_on) for robot in given.robots]
    for _, told in replies:
        print(told)
    return DONE if all(is_done for is_done, _ in replies) else REFUSED
