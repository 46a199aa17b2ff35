"""Standard messages as serialized bytes, without a message object in between.

A robot's seven topics carry a message each per tick. Building the Python message objects and converting them field by
field to and from the middleware's own costs about 350 us per robot and tick, most of the transport; packing the same
bytes directly costs a tenth of that. What goes over the wire is the ordinary serialized form of the standard messages,
so every ROS tool reads it; the tests pass it through the middleware's own serializer and back.

The form is CDR, version 1, little-endian: four bytes of encapsulation, then the fields in order, each aligned to its
size as counted from the end of the encapsulation. Strings are counted and end with a zero byte.

References
----------
.. [1] OMG, "DDS Interoperability Wire Protocol", v2.5, section 10 (data encapsulation).
"""

from __future__ import annotations

import struct
from functools import lru_cache

import numpy as np

from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.types import FloatArray

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Begins every little-endian CDR message."""

NANO = 1_000_000_000
"""Nanoseconds per second."""

_BASE = len(ENCAPSULATION)
_STAMP = struct.Struct("<iI")
_COUNT = struct.Struct("<I")
_PAIR = struct.Struct("<II")


class MessageError(SwarmError):
    """A message on a topic does not have the form that this system gives it."""


def is_little_endian(data: bytes) -> bool:
    """Return whether a serialized message is in the form that this module reads."""
    return data[:2] == ENCAPSULATION[:2]


def stamp(time: float) -> bytes:
    """Return the encapsulation and the stamp of a header, for a time [s]."""
    seconds, nanoseconds = divmod(round(time * NANO), NANO)
    return ENCAPSULATION + _STAMP.pack(seconds, nanoseconds)


@lru_cache(maxsize=4096)
def frame(name: str, next_size: int = 8) -> bytes:
    """Return the rest of a header after its stamp, for a frame name, aligned for a next field of `next_size` bytes."""
    text = name.encode() + b"\0"
    end = _STAMP.size + _COUNT.size + len(text)
    return _COUNT.pack(len(text)) + text + bytes(-end % next_size)


def read_header(data: bytes, next_size: int = 8) -> tuple[float, int]:
    """Return the time of a message that begins with a header [s], and where its next field of `next_size` bytes starts.

    Raises
    ------
    MessageError
        If the message ends before.
    """
    try:
        seconds, nanoseconds = _STAMP.unpack_from(data, _BASE)
        (length,) = _COUNT.unpack_from(data, _BASE + _STAMP.size)
    except struct.error as error:
        raise MessageError(f"message of {len(data)} bytes has no header") from error
    end = _STAMP.size + _COUNT.size + length
    return seconds + nanoseconds / NANO, _BASE + end + -end % next_size


def read_doubles(data: bytes, layout: struct.Struct, at: int) -> tuple[float, ...]:
    """Return the numbers that `layout` names, from position `at`.

    Raises
    ------
    MessageError
        If the message ends before.
    """
    try:
        return layout.unpack_from(data, at)
    except struct.error as error:
        raise MessageError(f"message of {len(data)} bytes ends within its fields") from error


def pose_array(stamped: bytes, name: str, poses: FloatArray) -> bytes:
    """Return a ``geometry_msgs/PoseArray``.

    Parameters
    ----------
    stamped : bytes
        From `stamp`.
    name : str
        Frame of the poses.
    poses : (n, 7) array
        Position x, y, z [m]; quaternion x, y, z, w.
    """
    start = stamped + frame(name, 4) + _COUNT.pack(len(poses))
    if not len(poses):
        return start
    return start + bytes(-(len(start) - _BASE) % 8) + np.ascontiguousarray(poses, dtype="<f8").tobytes()


def read_pose_array(data: bytes) -> tuple[float, FloatArray]:
    """Return the time [s] and the (n, 7) poses of a ``geometry_msgs/PoseArray``, as `pose_array` takes them.

    Raises
    ------
    MessageError
        If the message ends before.
    """
    time, at = read_header(data, 4)
    count, body = _read_count(data, at), at + 4 - _BASE
    return time, _read_array(data, 7 * count, _BASE + body + -body % 8 * bool(count)).reshape(count, 7)


def byte_array(payload: bytes) -> bytes:
    """Return a ``std_msgs/UInt8MultiArray`` without layout."""
    return b"".join((ENCAPSULATION, _PAIR.pack(0, 0), _COUNT.pack(len(payload)), payload))


def read_byte_array(data: bytes) -> bytes:
    """Return the bytes of a ``std_msgs/UInt8MultiArray``.

    Raises
    ------
    MessageError
        If the message is cut short.
    """
    at, _ = _skip_layout(data)
    count = _read_count(data, at)
    payload = data[at + 4 : at + 4 + count]
    if len(payload) != count:
        raise MessageError(f"byte array of {count} bytes carries {len(payload)}")
    return payload


def double_array(rows: FloatArray, labels: tuple[str, str], leading: tuple[float, ...]) -> bytes:
    """Return a ``std_msgs/Float64MultiArray`` that holds a table, after some leading numbers.

    Parameters
    ----------
    rows : (n, m) array
        The table.
    labels : (str, str)
        What its two dimensions are.
    leading : tuple of float
        Numbers before the table; the layout's data offset says how many.
    """
    n, m = rows.shape
    parts = bytearray(_COUNT.pack(2))
    for label, size, stride in ((labels[0], n, n * m), (labels[1], m, m)):
        text = label.encode() + b"\0"
        parts += _COUNT.pack(len(text)) + text + bytes(-len(text) % 4) + _PAIR.pack(size, stride)
    parts += _PAIR.pack(len(leading), len(leading) + n * m)
    parts += bytes(-len(parts) % 8)
    numbers = struct.pack(f"<{len(leading)}d", *leading) + np.ascontiguousarray(rows, dtype="<f8").tobytes()
    return ENCAPSULATION + parts + numbers


def read_double_array(data: bytes) -> tuple[FloatArray, FloatArray]:
    """Return the leading numbers, and the (n, m) table, of a ``std_msgs/Float64MultiArray``.

    Raises
    ------
    MessageError
        If it does not hold a table after its leading numbers, or is cut short.
    """
    at, sizes = _skip_layout(data)
    (leading,) = _COUNT.unpack_from(data, at - 4)
    count = _read_count(data, at)
    body = at + 4 - _BASE
    numbers = _read_array(data, count, _BASE + body + -body % 8)
    if len(sizes) != 2 or leading + sizes[0] * sizes[1] != count:
        raise MessageError(f"array of {count} numbers does not hold a table of size {sizes} after {leading} numbers")
    return numbers[:leading], numbers[leading:].reshape(sizes)


def _skip_layout(data: bytes) -> tuple[int, tuple[int, ...]]:
    """Return where the count of the data of a multi-array is, and the sizes of its dimensions."""
    at, sizes = _BASE + 4, []
    for _ in range(_read_count(data, _BASE)):
        end = at + 4 + _read_count(data, at)
        at = end + -(end - _BASE) % 4
        sizes.append(_read_count(data, at))
        at += _PAIR.size
    return at + 4, tuple(sizes)


def _read_count(data: bytes, at: int) -> int:
    try:
        count: int = _COUNT.unpack_from(data, at)[0]
    except struct.error as error:
        raise MessageError(f"message of {len(data)} bytes ends within its fields") from error
    return count


def _read_array(data: bytes, count: int, at: int) -> FloatArray:
    if at + 8 * count > len(data):
        raise MessageError(f"message of {len(data)} bytes ends within its {count} numbers")
    return np.frombuffer(data, "<f8", count, at).astype(np.float64)
