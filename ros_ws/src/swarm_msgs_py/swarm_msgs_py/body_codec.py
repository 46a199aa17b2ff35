"""Application records of `messages.bodies` as the bytes that a packet carries.

A body is one kind byte and the record's fields, little-endian and without padding: the place of a robot as ``float32``
[m], costs as unsigned 16 bit, camera fixes in 18 bytes each; for plans see `plan_codec`. Decoding is memoised on
the bytes: the fifty receivers of one body in a process share one record, whose arrays are read-only. Whoever *sends* a
body and must compute with exactly the numbers that its receivers see decodes its own bytes. No body is longer than
`BODY_MAX`, so each fits one packet.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from swarm_msgs_py.binary import Reader, checked, frozen, packed, packed_integers, packed_points
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.bodies import Body, CameraFixes, CostRow, Objective, Plan, Report, RowBundle, RowRequest
from swarm_msgs_py.messages.sensing import PoseFix
from swarm_msgs_py.plan_codec import decode_plan, encode_plan, shortening
from swarm_msgs_py.types import NodeId

_KIND = struct.Struct("<B")
_COUNT = struct.Struct("<H")
_ROW = struct.Struct("<IHBHBHH")  # epoch, robot, type, version, objective, weight; costs
_REQUEST = struct.Struct("<IH")  # epoch; rows held
_COST_SIZE = 2
_FIXES = struct.Struct("<IH")  # tick; fixes
_FIX = struct.Struct("<HfffHH")  # robot, x, y, yaw; sigma of place [10 um] and heading [1e-4 rad]
_REPORT = struct.Struct("<HBIhffBH")  # robot, type, epoch, goal, x, y, mode; sigma [cm]
_CM_PER_M = 100.0
_PLACE_STEPS_PER_M, _HEADING_STEPS_PER_RAD = 1e5, 1e4  # of the sigmas of fixes
_SIGMA_MAX = 0xFFFF  # steps
_ROUNDING = 1e-6  # steps; what was decoded is encoded as the same number
_OBJECTIVES = tuple(Objective)  # an objective travels as its number in this order

BODY_MAX = 65_500
"""Bytes of the longest body: what a frame, whose length travels as 16 bits, can carry."""

_PLAN_KIND, _ROW_KIND, _REQUEST_KIND, _BUNDLE_KIND, _REPORT_KIND, _FIXES_KIND = range(1, 7)


def encode_body(body: Body) -> bytes:
    """Return `body` as bytes.

    Raises
    ------
    FrameError
        If a value does not fit the format (e.g. a coordinate that is not finite), or the body is longer than
        `BODY_MAX`.
    """
    data = _encode(body)
    if len(data) > BODY_MAX:
        size = f"{type(body).__name__} of {len(data)} bytes; a packet carries at most {BODY_MAX}"
        raise FrameError(f"{size}; {shortening(body)}" if isinstance(body, Plan) else size)
    return data


def row_size(row: CostRow) -> int:
    """Return how many bytes a row adds to a `RowBundle`."""
    return _ROW.size + _COST_SIZE * len(row.costs)


def _encode(body: Body) -> bytes:
    if isinstance(body, Plan):
        return _KIND.pack(_PLAN_KIND) + encode_plan(body)
    if isinstance(body, CostRow):
        return _KIND.pack(_ROW_KIND) + _encode_row(body)
    if isinstance(body, RowRequest):
        head = packed(_REQUEST, body.epoch, len(body.held))
        return _KIND.pack(_REQUEST_KIND) + head + packed_integers([n for pair in body.held for n in pair], "<u2")
    if isinstance(body, RowBundle):
        return _KIND.pack(_BUNDLE_KIND) + packed(_COUNT, len(body.rows)) + b"".join(map(_encode_row, body.rows))
    if isinstance(body, CameraFixes):
        head = packed(_FIXES, body.tick, len(body.fixes))
        return _KIND.pack(_FIXES_KIND) + head + b"".join(map(_encode_fix, body.fixes))
    packed_points([body.position])  # refuses what is not finite
    sigma = _sigma_steps(body.sigma, _CM_PER_M)
    fields = (body.robot, body.robot_type, body.epoch, body.goal, *body.position, body.mode, sigma)
    return _KIND.pack(_REPORT_KIND) + packed(_REPORT, *fields)


def _sigma_steps(sigma: float, per_unit: float) -> int:
    """Return a standard deviation in steps, rounded up: who receives it may trust it too little, never too much."""
    return math.ceil(min(sigma * per_unit - _ROUNDING, _SIGMA_MAX))


def is_urgent(data: bytes) -> bool:
    """Return whether these are the bytes of a body that everybody waits for: a plan, without which rows say nothing."""
    return data[:1] == _KIND.pack(_PLAN_KIND)


def decode_body(data: bytes) -> Body:
    """Return the record that `data` stands for; shared, read-only.

    Raises
    ------
    FrameError
        If `data` is not exactly one body.
    """
    return _decode_plan(data) if is_urgent(data) else _decode_short(data)


@lru_cache(maxsize=16)  # plans are few, and take far more memory than bytes
def _decode_plan(data: bytes) -> Body:
    return _decode(data)


@lru_cache(maxsize=2048)
def _decode_short(data: bytes) -> Body:
    return _decode(data)


def _decode(data: bytes) -> Body:
    reader = Reader(data)
    (kind,) = reader.fields(_KIND)
    decode = _DECODERS.get(kind)
    if decode is None:
        raise FrameError(f"unknown kind of body: {kind}")
    body = decode(reader)
    reader.finish()
    return body


def _encode_row(row: CostRow) -> bytes:
    if row.weight < 1:
        raise FrameError(f"a row of weight {row.weight}")
    objective = _OBJECTIVES.index(row.objective)
    head = packed(_ROW, row.epoch, row.robot, row.robot_type, row.version, objective, row.weight, len(row.costs))
    return head + packed_integers(row.costs, "<u2")


def _decode_row(reader: Reader) -> CostRow:
    epoch, robot, robot_type, version, objective, weight, count = reader.fields(_ROW)
    if objective >= len(_OBJECTIVES):
        raise FrameError(f"unknown objective: {objective}")
    if weight < 1:  # would make all goals equally dear for a robot
        raise FrameError("a row of weight 0")
    costs = frozen(reader.array("<u2", count).astype(np.int64))
    return CostRow(epoch, NodeId(robot), robot_type, version, costs, weight, _OBJECTIVES[objective])


def _decode_request(reader: Reader) -> RowRequest:
    epoch, count = reader.fields(_REQUEST)
    numbers = reader.array("<u2", 2 * count).tolist()
    return RowRequest(epoch, tuple(zip(map(NodeId, numbers[::2]), numbers[1::2], strict=True)))


def _decode_bundle(reader: Reader) -> RowBundle:
    (count,) = reader.fields(_COUNT)
    return RowBundle(tuple(_decode_row(reader) for _ in range(count)))


def _decode_report(reader: Reader) -> Report:
    robot, robot_type, epoch, goal, x, y, mode, sigma = reader.fields(_REPORT)
    checked(np.array([x, y]))
    return Report(NodeId(robot), robot_type, epoch, goal, (x, y), mode, sigma / _CM_PER_M)


def _encode_fix(fix: PoseFix) -> bytes:
    packed_points([fix.position])  # refuses what is not finite
    if not abs(fix.yaw) <= math.tau:
        raise FrameError(f"a heading of {fix.yaw:g} rad")
    place = _sigma_steps(fix.position_sigma, _PLACE_STEPS_PER_M)
    heading = _sigma_steps(fix.yaw_sigma, _HEADING_STEPS_PER_RAD)
    return packed(_FIX, fix.robot, *fix.position, fix.yaw, max(place, 1), max(heading, 1))


def _decode_fixes(reader: Reader) -> CameraFixes:
    tick, count = reader.fields(_FIXES)
    return CameraFixes(tick, tuple(_decode_fix(reader) for _ in range(count)))


def _decode_fix(reader: Reader) -> PoseFix:
    robot, x, y, yaw, place, heading = reader.fields(_FIX)
    if not abs(yaw) <= math.tau:  # false for what is no number
        raise FrameError(f"a heading of {yaw:g} rad")
    if not (place and heading):  # a filter that is told so believes nothing else any more
        raise FrameError("a fix without error")
    position = frozen(checked(np.array([x, y])))
    return PoseFix(NodeId(robot), position, yaw, place / _PLACE_STEPS_PER_M, heading / _HEADING_STEPS_PER_RAD)


_DECODERS: dict[int, Callable[[Reader], Body]] = {
    _PLAN_KIND: decode_plan,
    _ROW_KIND: _decode_row,
    _REQUEST_KIND: _decode_request,
    _BUNDLE_KIND: _decode_bundle,
    _REPORT_KIND: _decode_report,
    _FIXES_KIND: _decode_fixes,
}
