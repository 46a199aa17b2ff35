"""Radio frames as bytes: versioned, length-checked, protected by a checksum.

Layout, little-endian, without padding::

    version u8 | kind u8 | source u16 | sequence u16 | length u16 | payload (length bytes) | CRC-16/XMODEM u16

    hello           position 2 i32 [mm] | velocity 2 i16 [mm/s] | sigma 2 u16 [mm] | correlation i8 [1/127]
                    | shared u8 [1/255] | tick u16 | type u8 | flags u8 | mode u8 | epoch u32 | digest u32
                    | rows: destination u16, hops u8, sequence u16
    packet          next hop u16 | origin u16 | destination u16 | number u16 | hops left u8 | body
    acknowledgement rows: transmitter u16, origin u16, number u16

A route row takes 5 bytes (spec section 5.3, rule 5, allows 6). Decoding is memoised on the bytes: all radios of one
process that hear a frame share one record, whose arrays are read-only; so fifty agents in a process stay cheap.

Several frames travel between a node and the world as one *batch* (one ROS message): tick u32 | flags u8 | (length u16 |
frame)*.
"""

from __future__ import annotations

import math
import struct
from binascii import crc_hqx
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from swarm_msgs_py.binary import COORDINATE_MAX, Reader, frozen, packed, packed_integers
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.radio import (
    NO_ROUTES,
    SIGMA_UNKNOWN,
    Acknowledgement,
    Frame,
    Hello,
    Packet,
    Presence,
    RouteRows,
)
from swarm_msgs_py.types import NodeId

__all__ = ["Batch", "decode_body", "decode_frame", "encode_body", "encode_frame", "pack_batch", "unpack_batch"]

VERSION = 1
_HELLO_KIND, _PACKET_KIND, _ACKNOWLEDGEMENT_KIND = 1, 2, 3
_HEADER = struct.Struct("<BBHHH")  # version, kind, source, sequence, length
_CHECK = struct.Struct("<H")
_PRESENCE = struct.Struct("<2i2h2HbBH3B2I")
_PACKET = struct.Struct("<4HB")  # next hop, origin, destination, number, hops left
_BATCH = struct.Struct("<IB")  # tick, flags
_LENGTH = struct.Struct("<H")
_IS_BEACON, _ASKS_FOR_WAY = 0x01, 0x02
_MM = 1000.0  # steps per meter
_SPEED_MAX = 32.767  # [m/s]; faster radios say so
_CORRELATION_STEPS, _SHARE_STEPS, _U16_MAX = 127, 255, 0xFFFF
_ROUNDING = 1e-9  # of a step: so much may arithmetic be off that computes a step from what was decoded of it
_GROWTH = 1.001  # of a sigma that is too small for its correlation

ROUTE_ROW = np.dtype([("destination", "<u2"), ("hops", "u1"), ("sequence", "<u2")])
"""One route row on the air."""

OVERHEAD = _HEADER.size + _CHECK.size
"""Bytes that a frame adds to its payload."""

FRAME_MAX = 0xFFFF
"""Bytes of the longest frame: a batch gives the length of a frame in 16 bits."""

HELLO_SIZE = OVERHEAD + _PRESENCE.size
"""Bytes of a hello without route rows."""


def encode_frame(frame: Frame) -> bytes:
    """Return `frame` as bytes.

    Raises
    ------
    FrameError
        If a value does not fit the format (e.g. a coordinate that is not finite), or the frame would be longer than
        `FRAME_MAX`.
    """
    if isinstance(frame, Hello):
        kind, payload = _HELLO_KIND, _encode_hello(frame)
    elif isinstance(frame, Packet):
        kind = _PACKET_KIND
        ends = (frame.next_hop, frame.origin, frame.destination, frame.number)
        payload = packed(_PACKET, *ends, frame.hops_left) + frame.body
    else:
        kind = _ACKNOWLEDGEMENT_KIND
        payload = packed_integers([n for triple in frame.packets for n in triple], "<u2")
    if len(payload) > FRAME_MAX - OVERHEAD:
        raise FrameError(f"{type(frame).__name__} of {len(payload) + OVERHEAD} bytes; a frame has at most {FRAME_MAX}")
    data = packed(_HEADER, VERSION, kind, frame.source, frame.sequence, len(payload)) + payload
    return data + _CHECK.pack(crc_hqx(data, 0))


@lru_cache(maxsize=8192)
def decode_frame(data: bytes) -> Frame:
    """Return the frame that `data` stands for; shared, read-only.

    Raises
    ------
    FrameError
        If `data` is not exactly one valid frame of this version.
    """
    if len(data) < OVERHEAD:
        raise FrameError(f"{len(data)} bytes are too few for a frame")
    if len(data) > FRAME_MAX:  # it could be read, but not passed on
        raise FrameError(f"{len(data)} bytes are too many for a frame, which has at most {FRAME_MAX}")
    version, kind, source, sequence, length = _HEADER.unpack_from(data)
    if version != VERSION:
        raise FrameError(f"frame of version {version}, not {VERSION}")
    if length != len(data) - OVERHEAD:
        raise FrameError(f"frame announces {length} bytes of payload and carries {len(data) - OVERHEAD}")
    if crc_hqx(data[: -_CHECK.size], 0) != _CHECK.unpack_from(data, len(data) - _CHECK.size)[0]:
        raise FrameError("checksum does not fit")
    reader = Reader(data, _HEADER.size, len(data) - _CHECK.size)
    if kind == _HELLO_KIND:
        return _decode_hello(NodeId(source), sequence, reader)
    if kind == _PACKET_KIND:
        next_hop, origin, destination, number, hops_left = reader.fields(_PACKET)
        ends = NodeId(next_hop), NodeId(origin), NodeId(destination)
        return Packet(NodeId(source), sequence, *ends, number, hops_left, reader.rest())
    if kind == _ACKNOWLEDGEMENT_KIND:
        return _decode_acknowledgement(NodeId(source), sequence, reader)
    raise FrameError(f"unknown kind of frame: {kind}")


def _encode_hello(hello: Hello) -> bytes:
    routes = hello.routes
    if not len(routes.destinations):
        return _encode_presence(hello.presence)
    rows = np.empty(len(routes.destinations), ROUTE_ROW)
    rows["destination"] = routes.destinations
    rows["hops"] = routes.hops
    rows["sequence"] = routes.sequences
    return _encode_presence(hello.presence) + rows.tobytes()


def _encode_presence(presence: Presence) -> bytes:
    x, y, vx, vy, xx, xy, yy, shared = presence.belief.tolist()
    if not all(abs(number) <= COORDINATE_MAX for number in (x, y, vx, vy)):  # false for NaN as well
        raise FrameError(f"position and velocity must be finite and within {COORDINATE_MAX:g}")
    is_known = max(xx, yy) < math.inf  # else the correlation means nothing, and may be infinity times zero
    if not (xx >= 0.0 and yy >= 0.0 and (math.isfinite(xy) or not is_known) and 0.0 <= shared <= 1.0):
        raise FrameError("a covariance must have variances that are not negative, and a share lie within 0 and 1")
    spread = _spread(xx, xy if is_known else 0.0, yy)
    share = math.floor(shared * _SHARE_STEPS + _ROUNDING)  # down: what is not shared counts as noise of the sender's
    vx, vy = (max(-_SPEED_MAX, min(_SPEED_MAX, speed)) for speed in (vx, vy))
    motion = (round(x * _MM), round(y * _MM), round(vx * _MM), round(vy * _MM))
    flags = presence.is_beacon * _IS_BEACON | presence.asks_for_way * _ASKS_FOR_WAY
    state = (presence.robot_type, flags, presence.mode, presence.epoch, presence.digest)
    return packed(_PRESENCE, *motion, *spread, share, presence.tick & _U16_MAX, *state)


def _spread(xx: float, xy: float, yy: float) -> tuple[int, int, int]:
    """Return both sigmas and the correlation, in steps, of a covariance that is no smaller in any direction.

    So a receiver may think too little of an estimate, never too much; what was rounded already stays as it is. With
    sigmas u and v times the true ones, and a correlation c instead of r, the difference of the two covariances is
    positive semidefinite if ``(u^2 - 1) (v^2 - 1) >= (u v c - r)^2``: the sigmas grow until a step of c fulfills it.
    A sigma of `SIGMA_UNKNOWN` cannot grow and says that nothing is known.
    """
    true = [min(math.sqrt(variance), SIGMA_UNKNOWN) * _MM for variance in (xx, yy)]
    scale = math.sqrt(xx) * math.sqrt(yy)  # each alone: their product may not be a number
    correlation = max(-1.0, min(1.0, xy / scale)) if 0.0 < scale < math.inf else 0.0
    sx, sy = (math.ceil(sigma - _ROUNDING) for sigma in true)
    while sx > 0 and sy > 0:
        u, v = sx / true[0], sy / true[1]
        steps = round(correlation / (u * v) * _CORRELATION_STEPS)
        room = math.sqrt(max(0.0, u * u - 1.0) * max(0.0, v * v - 1.0))
        if abs(u * v * steps / _CORRELATION_STEPS - correlation) <= room + _ROUNDING / _MM:
            return sx, sy, steps
        if max(sx, sy) == _U16_MAX:
            break
        sx, sy = (min(math.ceil(sigma * _GROWTH), _U16_MAX) for sigma in (sx, sy))
    return sx, sy, int(correlation * _CORRELATION_STEPS)


def _decode_hello(source: NodeId, sequence: int, reader: Reader) -> Hello:
    x, y, vx, vy, sx, sy, correlation, shared, tick, robot_type, flags, mode, epoch, digest = reader.fields(_PRESENCE)
    if max(abs(x), abs(y)) > COORDINATE_MAX * _MM or abs(correlation) > _CORRELATION_STEPS:
        raise FrameError(f"a position lies beyond {COORDINATE_MAX:g} m, or a correlation beyond 1")
    xx, yy = (sx / _MM) ** 2, (sy / _MM) ** 2
    xy = correlation / _CORRELATION_STEPS * (sx / _MM) * (sy / _MM)
    presence = Presence(
        position=frozen(np.array([x / _MM, y / _MM])),
        velocity=frozen(np.array([vx / _MM, vy / _MM])),
        covariance=frozen(np.array([[xx, xy], [xy, yy]])),
        shared=shared / _SHARE_STEPS,
        tick=tick,
        robot_type=robot_type,
        is_beacon=bool(flags & _IS_BEACON),
        mode=mode,
        epoch=epoch,
        digest=digest,
        asks_for_way=bool(flags & _ASKS_FOR_WAY),
    )
    rows = reader.array(ROUTE_ROW, reader.left() // ROUTE_ROW.itemsize)
    reader.finish()
    if not len(rows):
        return Hello(source, sequence, presence, NO_ROUTES)
    columns = (frozen(rows[name].astype(np.int64)) for name in ("destination", "hops", "sequence"))
    return Hello(source, sequence, presence, RouteRows(*columns))


def _decode_acknowledgement(source: NodeId, sequence: int, reader: Reader) -> Acknowledgement:
    numbers = reader.array("<u2", 3 * (reader.left() // 6)).tolist()
    reader.finish()
    triples = zip(map(NodeId, numbers[::3]), map(NodeId, numbers[1::3]), numbers[2::3], strict=True)
    return Acknowledgement(source, sequence, tuple(triples))


@dataclass(frozen=True, slots=True)
class Batch:
    """Frames of one node and tick, as one message.

    Attributes
    ----------
    tick : int
    flags : int
        Meaning is up to the two ends, 8 bits.
    frames : tuple of bytes
    """

    tick: int
    flags: int
    frames: tuple[bytes, ...]


def pack_batch(tick: int, flags: int, frames: Iterable[bytes]) -> bytes:
    """Return frames of one tick as one byte string.

    Raises
    ------
    FrameError
        If a frame is longer than 65535 bytes, or `tick` or `flags` do not fit.
    """
    parts = [packed(_BATCH, tick, flags)]
    for frame in frames:
        parts += [packed(_LENGTH, len(frame)), frame]
    return b"".join(parts)


def unpack_batch(data: bytes) -> Batch:
    """Return the batch that `data` stands for; the frames themselves are not looked into.

    Raises
    ------
    FrameError
        If `data` is not exactly one batch.
    """
    if len(data) < _BATCH.size:
        raise FrameError(f"{len(data)} bytes are too few for a batch")
    tick, flags = _BATCH.unpack_from(data)
    frames, at, end = [], _BATCH.size, len(data)
    while at < end:
        if end - at < _LENGTH.size:
            raise FrameError("batch ends within a length")
        start = at + _LENGTH.size
        at = start + _LENGTH.unpack_from(data, at)[0]
        if at > end:
            raise FrameError("batch ends within a frame")
        frames.append(data[start:at])
    return Batch(tick, flags, tuple(frames))
