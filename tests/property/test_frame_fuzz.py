"""Whatever arrives is either decoded or refused with `FrameError`; whatever was encoded comes back."""

from __future__ import annotations

from binascii import crc_hqx

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import decode_body, decode_frame, encode_body, encode_frame, pack_batch, unpack_batch
from swarm_msgs_py.messages.bodies import CostRow, Objective, Plan, Report, RowBundle, RowRequest, Task
from swarm_msgs_py.messages.radio import Acknowledgement, Frame, Hello, Packet, Presence, RouteRows
from swarm_msgs_py.partition import Method
from swarm_msgs_py.roster import Roster, TypeGroup

u8, u16, u32 = (st.integers(0, 2**bits - 1) for bits in (8, 16, 32))
float32 = st.floats(-1e6, 1e6, width=32)
centimeters = st.integers(-32_000, 32_000).map(lambda number: number / 100.0)  # what a plan keeps exactly


def points(smallest: int = 0) -> st.SearchStrategy[np.ndarray]:
    return st.integers(smallest, 6).flatmap(lambda n: arrays(np.float64, (n, 2), elements=centimeters))


def integers(limit: int, count: int) -> st.SearchStrategy[np.ndarray]:
    return arrays(np.int64, count, elements=st.integers(0, limit))


millimeters, millimeters_per_second = st.integers(-(10**9), 10**9), st.integers(-32767, 32767)
sigmas = st.integers(0, 65535)


def covariance_of(x: int, y: int, correlation: int) -> np.ndarray:
    """Return what a hello can say exactly: standard deviations in millimeters, correlation in steps of 1/127."""
    east, north = x / 1000.0, y / 1000.0
    cross = correlation / 127 * east * north if x and y else 0.0
    return np.array([[east**2, cross], [cross, north**2]])


covariances = st.builds(covariance_of, sigmas, sigmas, st.integers(-127, 127))
presences = st.builds(
    Presence,
    arrays(np.int64, 2, elements=millimeters).map(lambda n: n / 1000.0),
    arrays(np.int64, 2, elements=millimeters_per_second).map(lambda n: n / 1000.0),
    covariances,
    st.integers(0, 255).map(lambda n: n / 255),
    u16,
    u8,
    st.booleans(),
    mode=u8,
    epoch=u32,
    digest=u32,
)
route_rows = st.integers(0, 8).flatmap(
    lambda n: st.builds(RouteRows, integers(65535, n), integers(255, n), integers(65535, n))
)
frames = st.one_of(
    st.builds(Hello, u16, u16, presences, route_rows),
    st.builds(Packet, u16, u16, u16, u16, u16, u16, u8, st.binary(max_size=30)),
    st.builds(Acknowledgement, u16, u16, st.lists(st.tuples(u16, u16, u16), max_size=5).map(tuple)),
)
costs = st.integers(0, 6).flatmap(lambda n: integers(65535, n))
rows = st.builds(CostRow, u32, u16, u8, u16, costs, st.integers(1, 65535), st.sampled_from(Objective))
plans = st.integers(0, 5).flatmap(
    lambda n: st.builds(
        Plan,
        u32,
        points(),
        st.lists(points(), max_size=3).map(tuple),
        arrays(np.float64, (n, 2), elements=centimeters),
        integers(255, n),
    )
)
groups = st.builds(
    lambda number, count, radius: TypeGroup(type=number, count=count, coverage_radius_m=radius / 1000.0),
    st.integers(1, 255),
    st.integers(1, 250),
    st.integers(1, 65535),
)
rosters = st.lists(groups, min_size=1, max_size=4, unique_by=lambda group: group.type).map(
    lambda some: Roster(groups=tuple(some))
)
nowhere, nobody = st.just(np.empty((0, 2))), st.just(np.empty(0, dtype=np.int64))
outlines = st.lists(points(), max_size=3).map(tuple)
orders = st.one_of(
    st.builds(
        Plan, u32, points(), outlines, nowhere, nobody, st.just(0), st.just(Task.PARTITION), rosters,
        st.sampled_from(Method), u32,
    ),
    st.builds(
        Plan, u32, points(), outlines, nowhere, nobody, st.just(0), st.sampled_from([Task.FORCES, Task.FORCES_LITERAL]),
        rosters,
    ),
)  # fmt: skip
centimeters = st.integers(0, 0xFFFF).map(lambda steps: steps / 100.0)
bodies = st.one_of(
    plans,
    orders,
    rows,
    st.builds(RowRequest, u32, st.lists(st.tuples(u16, u16), max_size=5).map(tuple)),
    st.builds(RowBundle, st.lists(rows, max_size=3).map(tuple)),
    st.builds(Report, u16, u8, u32, st.integers(-(2**15), 2**15 - 1), st.tuples(float32, float32), u8, centimeters),
)


def as_plain(value: object) -> object:
    """Return nested records as nested tuples that compare by value."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tolist()
    if isinstance(value, tuple | list):
        return [as_plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return [as_plain(getattr(value, name)) for name in value.__dataclass_fields__]
    return value


@given(frames)
def test_every_frame_comes_back_as_it_was_sent(frame: Frame) -> None:
    data = encode_frame(frame)

    assert as_plain(decode_frame(data)) == as_plain(frame)
    assert encode_frame(decode_frame(data)) == data


@given(bodies)
def test_every_body_comes_back_as_it_was_sent(body: Plan | CostRow | RowRequest | RowBundle | Report) -> None:
    data = encode_body(body)

    assert as_plain(decode_body(data)) == as_plain(body)
    assert encode_body(decode_body(data)) == data


@given(st.lists(st.tuples(float32, float32), min_size=1, max_size=6))
def test_a_plan_of_any_extent_is_rounded_once_and_then_stays(places: list[tuple[float, float]]) -> None:
    sent = Plan(1, np.array(places), (), np.empty((0, 2)), np.empty(0, dtype=np.int64))

    data = encode_body(sent)
    heard = decode_body(data)

    assert isinstance(heard, Plan)
    step = max(0.01, 2.0 * float(np.ptp(sent.contour, axis=0).max()) / 65535)
    assert np.abs(heard.contour - sent.contour).max() <= step
    assert encode_body(heard) == data


@given(st.binary(max_size=120))
def test_random_bytes_never_do_more_than_raise_a_frame_error(data: bytes) -> None:
    for decode in (decode_frame, decode_body, unpack_batch):
        try:
            decode(data)
        except FrameError as error:
            assert "\n" not in str(error)  # noqa: PT017 - not raising is fine as well


@given(st.integers(1, 3), st.binary(max_size=120), u16, u16)
def test_random_payload_under_a_valid_checksum_is_decoded_exactly_or_refused(
    kind: int, payload: bytes, source: int, sequence: int
) -> None:
    head = bytes([1, kind]) + b"".join(n.to_bytes(2, "little") for n in (source, sequence, len(payload)))
    data = head + payload + crc_hqx(head + payload, 0).to_bytes(2, "little")

    try:
        frame = decode_frame(data)
    except FrameError:
        return
    assert frame.source == source
    if isinstance(frame, Hello):
        presence = frame.presence
        assert np.isfinite(presence.belief).all()
        assert np.abs(presence.position).max() <= 1e6
        assert 0.0 <= presence.shared <= 1.0
        assert np.array_equal(presence.covariance, presence.covariance.T)
        assert np.linalg.eigvalsh(presence.covariance).min() >= -1e-9 * max(1.0, float(presence.covariance.max()))


@given(st.integers(1, 5), st.binary(max_size=80))
def test_random_fields_of_a_body_are_finite_or_refused(kind: int, fields: bytes) -> None:
    try:
        body = decode_body(bytes([kind]) + fields)
    except FrameError:
        return
    if isinstance(body, Plan):
        assert all(np.isfinite(array).all() for array in (body.contour, body.goals, *body.obstacles))
    if isinstance(body, Report):
        assert np.isfinite(body.position).all()


@given(frames, st.data())
def test_one_damaged_bit_is_always_noticed(frame: Frame, data: st.DataObject) -> None:
    sent = bytearray(encode_frame(frame))
    sent[data.draw(st.integers(0, len(sent) - 1))] ^= 1 << data.draw(st.integers(0, 7))

    with pytest.raises(FrameError):
        decode_frame(bytes(sent))


@given(frames, st.data())
def test_a_frame_cut_short_is_always_noticed(frame: Frame, data: st.DataObject) -> None:
    sent = encode_frame(frame)

    with pytest.raises(FrameError):
        decode_frame(sent[: data.draw(st.integers(0, len(sent) - 1))])


@given(bodies, st.data())
def test_a_body_cut_short_is_always_noticed(
    body: Plan | CostRow | RowRequest | RowBundle | Report, data: st.DataObject
) -> None:
    sent = encode_body(body)

    with pytest.raises(FrameError):
        decode_body(sent[: data.draw(st.integers(0, len(sent) - 1))])


@given(u32, u8, st.lists(st.binary(max_size=20), max_size=5))
def test_batches_keep_tick_flags_and_frames(tick: int, flags: int, sent: list[bytes]) -> None:
    batch = unpack_batch(pack_batch(tick, flags, sent))

    assert (batch.tick, batch.flags, batch.frames) == (tick, flags, tuple(sent))
    assert_array_equal([len(frame) for frame in batch.frames], [len(frame) for frame in sent])
