"""How robots of the formation family sense, drive and show themselves over ROS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from swarm_msgs_py import topics
from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.messages.report import AgentReport
from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.ros import convert, views
from swarm_msgs_py.ros.dialect import Dialect, Sense
from swarm_msgs_py.step_io import AgentInputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import NodeId

# Plain numbers: arithmetic on enumeration members costs ten times as much.
_IMU, _FIX, _RANGES, _PROXIMITY = (int(part) for part in (Parts.IMU, Parts.FIX, Parts.RANGES, Parts.PROXIMITY))


def stamped(decode: Callable[[bytes], tuple[float, Any]]) -> Callable[[bytes, float], tuple[int, Any]]:
    """Return a decoder that tells the tick instead of the time."""

    def decoded(data: bytes, period_s: float) -> tuple[int, Any]:
        time, reading = decode(data)
        return convert.tick_at(time, period_s), reading

    return decoded


def _join(tick: int, time: float, readings: Mapping[int, Any], frames: tuple[bytes, ...]) -> AgentInputs:
    ranges, proximity = readings.get(_RANGES), readings.get(_PROXIMITY)
    return AgentInputs(
        tick=tick,
        time=time,
        imu=readings[_IMU],
        fix=readings.get(_FIX),
        ranges=RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0)) if ranges is None else ranges,
        proximity=np.zeros((0, 2)) if proximity is None else proximity,
        inbox=frames,
    )


def _encode_fix(stamp: bytes, robot: NodeId, inputs: AgentInputs) -> bytes:  # noqa: ARG001 - a fix is in the map frame
    assert inputs.fix is not None  # else it would not be asked for
    return convert.encode_fix(stamp, inputs.fix)


FORMATION: Dialect[AgentInputs, VelocityCommand, AgentReport] = Dialect(
    senses=(
        Sense(
            _IMU,
            topics.IMU,
            lambda stamp, robot, inputs: convert.encode_imu(stamp, convert.body_frame(robot), inputs.imu),
            stamped(convert.decode_imu),
            lambda _: True,
        ),
        Sense(_FIX, topics.FIX, _encode_fix, stamped(convert.decode_fix), lambda inputs: inputs.fix is not None),
        Sense(
            _RANGES,
            topics.RANGES,
            lambda _stamp, _robot, inputs: convert.encode_ranges(inputs.tick, inputs.ranges),
            lambda data, _: convert.decode_ranges(data),
            lambda inputs: len(inputs.ranges.neighbors) > 0,
        ),
        Sense(
            _PROXIMITY,
            topics.PROXIMITY,
            lambda stamp, robot, inputs: convert.encode_proximity(stamp, convert.body_frame(robot), inputs.proximity),
            stamped(convert.decode_proximity),
            lambda inputs: len(inputs.proximity) > 0,
            tells_viewers=True,  # a viewer beside the robot has to learn that there is nothing near any more
        ),
    ),
    required=_IMU,
    join=_join,
    encode_command=lambda stamp, robot, command: convert.encode_command(stamp, convert.body_frame(robot), command),
    decode_command=convert.decode_command,
    views=((topics.ODOM, views.odometry), (topics.PATH, views.path), (topics.STATUS, views.status)),
)
"""The formation family."""
