"""When a serialized message was true, in simulated time: recorded times do not depend on how busy the machine was."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping

from swarm_msgs_py.frames import unpack_batch
from swarm_msgs_py.ros import cdr, convert
from swarm_msgs_py.topics import MARKERS, Channel, Party

Stamp = Callable[[bytes, float], float]
"""Time of a message [s], of its bytes and the period of a tick [s]."""

_TIME = struct.Struct("<iI")
_BASE = len(cdr.ENCAPSULATION)
_AFTER_COUNT = _BASE + 4  # the stamp of the first of counted things


def time_of(channel: Channel, data: bytes, period_s: float) -> float | None:
    """Return when a message was true [s]: what it says, or the start of the tick that it names.

    None for orders of an operator, which may carry no time or the time of another clock.

    Raises
    ------
    MessageError
        If it is too short to say so.
    """
    if channel.source is Party.OPERATOR:
        return None
    return _STAMPS.get(channel.message, _leading)(data, period_s)


def _leading(data: bytes, period_s: float) -> float:  # noqa: ARG001 - one of several
    """Return the time with which a message begins, as the clock and all that have a header do."""
    return _read(data, _BASE)


def _of_first(data: bytes, period_s: float) -> float:  # noqa: ARG001 - one of several
    return _read(data, _AFTER_COUNT)


def _of_batch(data: bytes, period_s: float) -> float:
    return unpack_batch(convert.decode_batch(data)).tick * period_s


def _of_table(data: bytes, period_s: float) -> float:
    leading, _ = cdr.read_double_array(data)
    return float(leading[0]) * period_s


def _read(data: bytes, at: int) -> float:
    try:
        seconds, nanoseconds = _TIME.unpack_from(data, at)
    except struct.error as error:
        raise cdr.MessageError(f"message of {len(data)} bytes has no time") from error
    return float(seconds + nanoseconds / cdr.NANO)


_STAMPS: Mapping[str, Stamp] = {
    "std_msgs/msg/UInt8MultiArray": _of_batch,
    "std_msgs/msg/Float64MultiArray": _of_table,
    MARKERS.message: _of_first,
}
