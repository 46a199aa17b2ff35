"""How robots of the coverage family sense, drive and show themselves over ROS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_msgs_py import topics
from swarm_msgs_py.coverage_io import CoverageInputs, CoverageReport
from swarm_msgs_py.ros import convert, views
from swarm_msgs_py.ros.dialect import Dialect, Sense
from swarm_msgs_py.ros.formation_dialect import stamped
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import FloatArray, NodeId

_FIX, _NEIGHBORS = int(Parts.FIX), int(Parts.NEIGHBORS)
_ALONE = np.zeros(0, dtype=np.int64), np.zeros((0, 3))


def _join(tick: int, time: float, readings: Mapping[int, Any], frames: tuple[bytes, ...]) -> CoverageInputs:
    ids, offsets = readings.get(_NEIGHBORS, _ALONE)
    return CoverageInputs(tick, time, ids, offsets, readings.get(_FIX), frames)


def _encode_fix(stamp: bytes, robot: NodeId, inputs: CoverageInputs) -> bytes:  # noqa: ARG001 - in the map frame
    assert inputs.position is not None  # else it would not be asked for
    return convert.encode_place(stamp, inputs.position)


COVERAGE: Dialect[CoverageInputs, FloatArray, CoverageReport] = Dialect(
    senses=(
        Sense(_FIX, topics.FIX, _encode_fix, stamped(convert.decode_place), lambda inputs: inputs.position is not None),
        Sense(
            _NEIGHBORS,
            topics.NEIGHBORS,
            lambda _stamp, _robot, inputs: convert.encode_neighbors(inputs.tick, inputs.ids, inputs.offsets),
            lambda data, _: convert.decode_neighbors(data),
            lambda inputs: len(inputs.ids) > 0,
        ),
    ),
    required=0,
    join=_join,
    encode_command=lambda stamp, robot, velocity: convert.encode_velocity(stamp, convert.body_frame(robot), velocity),
    decode_command=convert.decode_velocity,
    views=(
        (topics.ODOM, views.point_odometry),
        (topics.PATH, views.point_path),
        (topics.STATUS, views.point_status),
    ),
)
"""The coverage family."""
