"""How boats sense, drive and show themselves over ROS."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_msgs_py import topics
from swarm_msgs_py.assembly.boat_io import AssemblyInputs, AssemblyReport
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.ros import convert, views
from swarm_msgs_py.ros.dialect import Dialect, Sense
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import FloatArray, NodeId

_BOAT = int(Parts.BOAT)


def _encode_boat(stamp: bytes, robot: NodeId, inputs: AssemblyInputs) -> bytes:  # noqa: ARG001 - tells the tick itself
    bits = sum(1 << face for face in inputs.contacts)
    seen = np.column_stack([inputs.seen, np.zeros(len(inputs.seen))])
    return convert.encode_boat(inputs.tick, bits, np.vstack([inputs.pose, inputs.reference, seen]))


def _join(tick: int, time: float, readings: Mapping[int, Any], frames: tuple[bytes, ...]) -> AssemblyInputs:
    bits, poses = readings[_BOAT]
    contacts = frozenset(face for face in Face if bits & (1 << face))
    return AssemblyInputs(tick, time, poses[0], poses[1], contacts, frames, poses[2:, :2])


ASSEMBLY: Dialect[AssemblyInputs, FloatArray, AssemblyReport] = Dialect(
    senses=(Sense(_BOAT, topics.BOAT, _encode_boat, lambda data, _: convert.decode_boat(data), lambda _: True),),
    required=_BOAT,
    join=_join,
    encode_command=lambda stamp, _robot, velocity: convert.encode_drift(stamp, velocity),
    decode_command=convert.decode_drift,
    views=((topics.ODOM, views.boat_odometry), (topics.PATH, views.boat_path), (topics.STATUS, views.boat_status)),
)
"""The assembly family."""
