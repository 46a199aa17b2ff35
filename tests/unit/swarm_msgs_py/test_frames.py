from __future__ import annotations

import struct
from binascii import crc_hqx
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import FRAME_MAX, HELLO_SIZE, OVERHEAD, decode_frame, encode_frame, pack_batch, unpack_batch
from swarm_msgs_py.messages.radio import Acknowledgement, Hello, Packet, Presence, RouteRows
from swarm_msgs_py.types import EVERYONE, MISSION, NodeId

PRESENCE = Presence(np.array([1.5, -2.25]), np.array([0.25, 0.5]), 0.125, 2, True, 3, 70000, 0xDEADBEEF)


def make_rows(*rows: tuple[int, int, int]) -> RouteRows:
    columns = np.array(rows, dtype=np.int64).reshape(-1, 3).T
    return RouteRows(*columns)


def make_hello(*rows: tuple[int, int, int], presence: Presence = PRESENCE) -> Hello:
    return Hello(NodeId(7), 65535, presence, make_rows(*rows))


def with_valid_checksum(data: bytes) -> bytes:
    return data[:-2] + crc_hqx(data[:-2], 0).to_bytes(2, "little")


def test_hello_survives_the_air() -> None:
    decoded = decode_frame(encode_frame(make_hello((7, 0, 42), (MISSION, 255, 65535))))

    assert isinstance(decoded, Hello)
    assert (decoded.source, decoded.sequence) == (7, 65535)
    assert_allclose(decoded.presence.position, [1.5, -2.25])
    assert_allclose(decoded.presence.velocity, [0.25, 0.5])
    state = decoded.presence
    assert (state.sigma, state.robot_type, state.is_beacon) == (0.125, 2, True)
    assert (state.mode, state.epoch, state.digest) == (3, 70000, 0xDEADBEEF)
    assert_array_equal(decoded.routes.destinations, [7, MISSION])
    assert_array_equal(decoded.routes.hops, [0, 255])
    assert_array_equal(decoded.routes.sequences, [42, 65535])


def test_packet_survives_the_air() -> None:
    packet = Packet(NodeId(1), 2, EVERYONE, NodeId(3), MISSION, 4, 5, b"body")

    assert decode_frame(encode_frame(packet)) == packet


def test_acknowledgement_survives_the_air() -> None:
    frame = Acknowledgement(NodeId(1), 2, ((NodeId(3), NodeId(4), 5), (NodeId(6), NodeId(7), 65535)))

    assert decode_frame(encode_frame(frame)) == frame


def test_full_dump_of_fifty_rows_takes_about_three_hundred_bytes() -> None:
    rows = [(destination, 3, 100) for destination in range(50)]

    assert len(encode_frame(make_hello(*rows))) == HELLO_SIZE + 50 * 5 < 310


def test_receivers_share_one_read_only_record() -> None:
    data = encode_frame(make_hello((7, 0, 42)))
    first, second = decode_frame(data), decode_frame(bytes(bytearray(data)))

    assert first is second
    assert isinstance(first, Hello)
    for array in (first.presence.position, first.presence.velocity, first.routes.hops, first.routes.sequences):
        assert not array.flags.writeable


def test_unknown_position_may_have_infinite_sigma() -> None:
    decoded = decode_frame(encode_frame(make_hello(presence=replace(PRESENCE, sigma=np.inf))))

    assert isinstance(decoded, Hello)
    assert decoded.presence.sigma == np.inf


@pytest.mark.parametrize(
    "broken",
    [
        replace(PRESENCE, position=np.array([np.nan, 0.0])),
        replace(PRESENCE, velocity=np.array([0.0, np.inf])),
        replace(PRESENCE, sigma=-1.0),
        replace(PRESENCE, sigma=np.nan),
        replace(PRESENCE, position=np.array([1e39, 0.0])),
        replace(PRESENCE, epoch=-1),
        replace(PRESENCE, digest=1 << 32),
    ],
    ids=["nan position", "infinite velocity", "negative sigma", "nan sigma", "beyond float32", "epoch", "digest"],
)
def test_sender_cannot_encode_nonsense(broken: Presence) -> None:
    with pytest.raises(FrameError):
        encode_frame(make_hello(presence=broken))


@pytest.mark.parametrize("offset", [8, 12, 16, 20], ids=["x", "y", "vx", "vy"])
@pytest.mark.parametrize("pattern", [b"\x00\x00\xc0\x7f", b"\x00\x00\x80\xff"], ids=["nan", "minus infinity"])
def test_receiver_refuses_numbers_that_are_not_finite(offset: int, pattern: bytes) -> None:
    data = bytearray(encode_frame(make_hello()))
    data[offset : offset + 4] = pattern

    with pytest.raises(FrameError, match="finite"):
        decode_frame(with_valid_checksum(bytes(data)))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "too few"),
        (bytes(OVERHEAD - 1), "too few"),
        (b"\x02" + bytes(OVERHEAD - 1), "version 2"),
        (b"\x01\x01\x00\x00\x00\x00\x05\x00\x00\x00", "announces 5"),
        (with_valid_checksum(b"\x01\x09\x00\x00\x00\x00\x00\x00\x00\x00"), "unknown kind"),
        (with_valid_checksum(b"\x01\x02\x00\x00\x00\x00\x00\x00\x00\x00"), "ends early"),
        (with_valid_checksum(b"\x01\x03\x00\x00\x00\x00\x01\x00\x00\x00\x00"), "too many"),
    ],
    ids=["empty", "short", "version", "length", "kind", "no fields", "half a row"],
)
def test_receiver_names_what_is_wrong(data: bytes, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        decode_frame(data)


def test_damaged_frame_fails_its_checksum() -> None:
    data = bytearray(encode_frame(make_hello((7, 0, 42))))
    data[10] ^= 0x04

    with pytest.raises(FrameError, match="checksum"):
        decode_frame(bytes(data))


def test_batch_survives_the_bus() -> None:
    batch = unpack_batch(pack_batch(123456, 0b101, [b"one", b"", b"three"]))

    assert (batch.tick, batch.flags, batch.frames) == (123456, 0b101, (b"one", b"", b"three"))


@pytest.mark.parametrize("cut", range(1, 14))
def test_batch_cut_short_is_refused_unless_it_ends_between_two_frames(cut: int) -> None:
    whole = pack_batch(1, 0, [b"one", b"two"])
    assert len(whole) == 15

    if cut == 5:
        assert unpack_batch(whole[:-cut]).frames == (b"one",)
    elif cut == 10:
        assert unpack_batch(whole[:-cut]).frames == ()
    else:
        with pytest.raises(FrameError):
            unpack_batch(whole[:-cut])


def test_batch_refuses_a_frame_that_its_length_field_cannot_hold() -> None:
    with pytest.raises(FrameError, match="fit"):
        pack_batch(0, 0, [bytes(65536)])


def test_a_frame_that_no_batch_could_carry_is_refused_by_size_on_both_ends() -> None:
    longest = Packet(NodeId(1), 2, EVERYONE, NodeId(3), MISSION, 4, 5, bytes(FRAME_MAX - OVERHEAD - 9))
    data = encode_frame(longest)

    assert len(data) == FRAME_MAX
    assert unpack_batch(pack_batch(0, 0, [data])).frames == (data,)
    with pytest.raises(FrameError, match="Packet of 65536 bytes; a frame has at most 65535"):
        encode_frame(replace(longest, body=longest.body + b"x"))
    with pytest.raises(FrameError, match="too many"):
        decode_frame(data + b"x")


@pytest.mark.parametrize("number", [2e6, -3e38, float("nan"), float("inf")])
@pytest.mark.parametrize("place", [0, 3])
def test_a_hello_from_nowhere_is_refused_on_both_ends(number: float, place: int) -> None:
    numbers = [0.0, 0.0, 0.0, 0.0]
    numbers[place] = number
    presence = replace(PRESENCE, position=np.array(numbers[:2]), velocity=np.array(numbers[2:]))
    data = bytearray(encode_frame(make_hello()))
    data[8 + 4 * place : 12 + 4 * place] = struct.pack("<f", number)

    with pytest.raises(FrameError, match="must be finite and within"):
        encode_frame(make_hello(presence=presence))
    with pytest.raises(FrameError, match="must be finite and within"):
        decode_frame(with_valid_checksum(bytes(data)))
