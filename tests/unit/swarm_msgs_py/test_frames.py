from __future__ import annotations

import struct
from binascii import crc_hqx
from dataclasses import replace

import numpy as np
import pytest
from builders import make_presence
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import FRAME_MAX, HELLO_SIZE, OVERHEAD, decode_frame, encode_frame, pack_batch, unpack_batch
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Acknowledgement, Hello, Packet, Presence, RouteRows
from swarm_msgs_py.types import EVERYONE, MISSION, NodeId

COVARIANCE = np.array([[0.25, 0.05], [0.05, 0.04]])
PRESENCE = make_presence(
    position=np.array([1.5, -2.25]),
    velocity=np.array([0.25, 0.5]),
    covariance=COVARIANCE,
    shared=0.4,
    tick=70001,
    robot_type=2,
    mode=3,
    epoch=70000,
    digest=0xDEADBEEF,
)


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
    assert_allclose(state.covariance, COVARIANCE, rtol=0.02)
    assert_allclose(state.belief, [1.5, -2.25, 0.25, 0.5, *state.covariance.ravel()[[0, 1, 3]], 0.4])
    assert (state.tick, state.robot_type, state.is_beacon) == (70001 % 2**16, 2, True)
    assert (state.mode, state.epoch, state.digest) == (3, 70000, 0xDEADBEEF)
    assert_array_equal(decoded.routes.destinations, [7, MISSION])
    assert_array_equal(decoded.routes.hops, [0, 255])
    assert_array_equal(decoded.routes.sequences, [42, 65535])


@pytest.mark.parametrize("is_beacon", [False, True])
@pytest.mark.parametrize("asks_for_way", [False, True])
def test_the_flags_of_a_hello_are_heard_one_by_one(is_beacon: bool, asks_for_way: bool) -> None:
    said = replace(PRESENCE, is_beacon=is_beacon, asks_for_way=asks_for_way)

    heard = decode_frame(encode_frame(make_hello(presence=said)))

    assert isinstance(heard, Hello)
    assert (heard.presence.is_beacon, heard.presence.asks_for_way) == (is_beacon, asks_for_way)


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


@pytest.mark.parametrize("sigma", [SIGMA_UNKNOWN, 1e3, np.inf])
def test_who_does_not_know_where_it_is_says_the_largest_sigma(sigma: float) -> None:
    decoded = decode_frame(encode_frame(make_hello(presence=make_presence(sigma=sigma))))

    assert isinstance(decoded, Hello)
    assert decoded.presence.sigma == pytest.approx(SIGMA_UNKNOWN)


def heard_presence(presence: Presence) -> Presence:
    decoded = decode_frame(encode_frame(make_hello(presence=presence)))
    assert isinstance(decoded, Hello)
    return decoded.presence


sigmas = st.floats(0.0, 60.0) | st.floats(0.0, 0.01)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(sigmas, sigmas, st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_nobody_thinks_more_of_an_estimate_than_its_owner(
    x: float, y: float, correlation: float, shared: float
) -> None:
    """In no direction, whatever the rounding of three numbers does."""
    covariance = np.array([[x * x, correlation * x * y], [correlation * x * y, y * y]])
    heard = heard_presence(make_presence(covariance=covariance, shared=shared))

    tolerance = 1e-9 * max(1.0, x * x + y * y)
    assert np.linalg.eigvalsh(heard.covariance - covariance).min() >= -tolerance
    assert np.linalg.eigvalsh(heard.covariance).min() >= -tolerance
    assert shared - 1 / 255 < heard.shared <= shared + 1e-9
    # Nor much less: a quarter of a percent for the correlation, and some millimeters.
    assert_allclose(np.sqrt(np.diag(heard.covariance)), [x, y], rtol=0.005, atol=0.005)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(sigmas, sigmas, st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_what_was_heard_is_told_on_unchanged(x: float, y: float, correlation: float, shared: float) -> None:
    covariance = np.array([[x * x, correlation * x * y], [correlation * x * y, y * y]])
    once = heard_presence(make_presence(covariance=covariance, shared=shared))

    assert_array_equal(heard_presence(once).belief, once.belief)


def test_a_speed_that_no_robot_has_saturates() -> None:
    presence = make_presence(velocity=np.array([1e3, -1e3]))
    decoded = decode_frame(encode_frame(make_hello(presence=presence)))

    assert isinstance(decoded, Hello)
    assert_allclose(decoded.presence.velocity, [32.767, -32.767])


@pytest.mark.parametrize(
    "broken",
    [
        replace(PRESENCE, position=np.array([np.nan, 0.0])),
        replace(PRESENCE, velocity=np.array([0.0, np.inf])),
        replace(PRESENCE, covariance=-COVARIANCE),
        replace(PRESENCE, covariance=np.full((2, 2), np.nan)),
        replace(PRESENCE, shared=1.5),
        replace(PRESENCE, position=np.array([1e39, 0.0])),
        replace(PRESENCE, epoch=-1),
        replace(PRESENCE, digest=1 << 32),
    ],
    ids=["nan position", "infinite velocity", "negative variance", "nan variance", "share", "far", "epoch", "digest"],
)
def test_sender_cannot_encode_nonsense(broken: Presence) -> None:
    with pytest.raises(FrameError):
        encode_frame(make_hello(presence=broken))


@pytest.mark.parametrize(
    ("offset", "pattern"),
    [(8, b"\xff\xff\xff\x7f"), (12, b"\x00\x00\x00\x80"), (24, b"\x80")],
    ids=["x far to the east", "y far to the south", "correlation"],
)
def test_receiver_refuses_what_no_sender_says(offset: int, pattern: bytes) -> None:
    data = bytearray(encode_frame(make_hello()))
    data[offset : offset + len(pattern)] = pattern

    with pytest.raises(FrameError, match="beyond"):
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
@pytest.mark.parametrize("place", [0, 1, 2, 3])
def test_a_hello_from_nowhere_is_refused_by_the_sender(number: float, place: int) -> None:
    numbers = [0.0, 0.0, 0.0, 0.0]
    numbers[place] = number
    presence = replace(PRESENCE, position=np.array(numbers[:2]), velocity=np.array(numbers[2:]))

    with pytest.raises(FrameError, match="must be finite and within"):
        encode_frame(make_hello(presence=presence))


@pytest.mark.parametrize("millimeters", [1_000_000_001, -1_000_000_001, 2**31 - 1, -(2**31)])
@pytest.mark.parametrize("place", [0, 1])
def test_a_hello_from_nowhere_is_refused_by_the_receiver(millimeters: int, place: int) -> None:
    data = bytearray(encode_frame(make_hello()))
    data[8 + 4 * place : 12 + 4 * place] = struct.pack("<i", millimeters)

    with pytest.raises(FrameError, match="position lies beyond"):
        decode_frame(with_valid_checksum(bytes(data)))


@pytest.mark.parametrize("edge", [1e6, -1e6])
def test_a_hello_from_the_edge_of_the_world_is_heard(edge: float) -> None:
    decoded = decode_frame(encode_frame(make_hello(presence=replace(PRESENCE, position=np.array([edge, -edge])))))

    assert isinstance(decoded, Hello)
    assert decoded.presence.position.tolist() == [edge, -edge]


@pytest.mark.parametrize("covariance", [[[np.inf, np.nan], [np.nan, 1.0]], [[4.0, np.inf], [np.inf, np.inf]]])
def test_a_robot_that_knows_one_coordinate_at_most_is_heard_to_know_none_of_the_correlation(
    covariance: list[list[float]],
) -> None:
    decoded = decode_frame(encode_frame(make_hello(presence=replace(PRESENCE, covariance=np.array(covariance)))))

    assert isinstance(decoded, Hello)
    heard = decoded.presence.covariance
    assert heard.max() == pytest.approx(SIGMA_UNKNOWN**2)
    assert heard[0, 1] == heard[1, 0] == 0.0


@pytest.mark.parametrize("tick", [0, 65535, 65536, 10**9])
def test_ticks_are_heard_modulo_two_to_the_sixteenth(tick: int) -> None:
    decoded = decode_frame(encode_frame(make_hello(presence=replace(PRESENCE, tick=tick))))

    assert isinstance(decoded, Hello)
    assert decoded.presence.tick == tick % 65536


@pytest.mark.parametrize("variance", [1e-300, 5e-324, 1e200, 1e308])
def test_extreme_variances_are_encoded_without_overflow(variance: float) -> None:
    covariance = np.array([[variance, 0.5 * variance], [0.5 * variance, variance]])
    decoded = decode_frame(encode_frame(make_hello(presence=replace(PRESENCE, covariance=covariance))))

    assert isinstance(decoded, Hello)
    assert np.isfinite(decoded.presence.covariance).all()
    assert decoded.presence.sigma >= min(np.sqrt(variance), SIGMA_UNKNOWN) - 1e-8
