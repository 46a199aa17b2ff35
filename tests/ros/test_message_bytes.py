"""The directly packed messages are what the middleware itself would have sent and read."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped, TwistStamped
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64MultiArray, UInt8MultiArray

from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.orientation import quaternion_of, yaw_of
from swarm_msgs_py.ros import cdr, convert

finite = st.floats(allow_nan=False, allow_infinity=False)
speeds = st.floats(-1e6, 1e6)
names = st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=20)
times = st.integers(0, 10**6).map(lambda tick: tick * 0.05)
points = arrays(np.float64, st.tuples(st.integers(0, 20), st.just(2)), elements=finite)


def from_middleware(data: bytes, message_type: Any) -> bytes:
    """Let the middleware read the bytes and write them again; where it pads, it writes whatever is in memory."""
    written: bytes = serialize_message(deserialize_message(data, message_type))
    assert len(written) == len(data)
    return written


@given(yaw=st.floats(-2 * math.pi, 2 * math.pi, exclude_min=True, exclude_max=True, allow_subnormal=False))
def test_a_heading_survives_its_quaternion_unchanged(yaw: float) -> None:
    z, w = quaternion_of(yaw)

    assert yaw_of(z, w) == yaw
    assert z * z + w * w == pytest.approx(1.0, abs=1e-14)


@given(time=times, name=names, acceleration=arrays(np.float64, 2, elements=finite), rate=finite)
def test_an_imu_sample_survives_unchanged(time: float, name: str, acceleration: np.ndarray, rate: float) -> None:
    data = convert.encode_imu(cdr.stamp(time), name, ImuSample(acceleration, 0.25, rate))

    stamped, sample = convert.decode_imu(from_middleware(data, Imu))

    assert convert.tick_at(stamped, 0.05) == convert.tick_at(time, 0.05)
    assert sample.acceleration_body.tobytes() == acceleration.tobytes()
    assert (sample.yaw, sample.yaw_rate) == (0.25, rate)


def test_an_imu_message_says_what_a_ros_tool_expects_to_read() -> None:
    sample = ImuSample(np.array([0.5, -0.25]), math.pi / 2, 0.125)

    message = deserialize_message(convert.encode_imu(cdr.stamp(12.5), "r07/base_link", sample), Imu)

    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 500_000_000)
    assert message.header.frame_id == "r07/base_link"
    assert (message.orientation.z, message.orientation.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    assert message.angular_velocity.z == 0.125
    assert (message.linear_acceleration.x, message.linear_acceleration.y) == (0.5, -0.25)


@given(time=times, position=arrays(np.float64, 2, elements=finite), sigma=st.floats(1e-100, 1e100))
def test_a_fix_survives_unchanged(time: float, position: np.ndarray, sigma: float) -> None:
    data = convert.encode_fix(cdr.stamp(time), PositionFix(position, sigma))

    _, fix = convert.decode_fix(from_middleware(data, PoseWithCovarianceStamped))

    assert fix.position.tobytes() == position.tobytes()
    assert fix.sigma == sigma


def test_a_fix_message_says_what_a_ros_tool_expects_to_read() -> None:
    data = convert.encode_fix(cdr.stamp(0.5), PositionFix(np.array([3.0, 4.0]), 0.5))

    message = deserialize_message(data, PoseWithCovarianceStamped)

    covariance = np.array(message.pose.covariance).reshape(6, 6)
    assert (message.pose.pose.position.x, message.pose.pose.position.y) == (3.0, 4.0)
    assert np.diag(covariance).tolist() == [0.25, 0.25, *[convert.UNMEASURED_VARIANCE] * 4]
    assert np.count_nonzero(covariance) == 6


@given(tick=st.integers(0, 2**32 - 1), readings=st.dictionaries(st.integers(0, 65535), finite, max_size=20))
def test_a_range_scan_survives_unchanged(tick: int, readings: dict[int, float]) -> None:
    neighbors = np.array(sorted(readings), dtype=np.int64)
    ranges = np.array([readings[n] for n in sorted(readings)], dtype=np.float64)
    data = convert.encode_ranges(tick, RangeScan(neighbors, ranges))

    stamped, scan = convert.decode_ranges(from_middleware(data, Float64MultiArray))

    assert stamped == tick
    assert scan.neighbors.tolist() == neighbors.tolist()
    assert scan.ranges.tobytes() == ranges.tobytes()


@given(time=times, name=names, near=points)
def test_proximity_points_survive_unchanged(time: float, name: str, near: np.ndarray) -> None:
    data = convert.encode_proximity(cdr.stamp(time), name, near)

    _, seen = convert.decode_proximity(from_middleware(data, PoseArray))

    assert seen.shape == near.shape
    assert seen.tobytes() == near.tobytes()


@given(time=times, name=names, forward=speeds, left=speeds, turn=speeds)
def test_a_command_survives_unchanged(time: float, name: str, forward: float, left: float, turn: float) -> None:
    data = convert.encode_command(cdr.stamp(time), name, VelocityCommand(forward, left, turn))

    _, command = convert.decode_command(from_middleware(data, TwistStamped))

    assert command == VelocityCommand(forward, left, turn)


@given(batch=st.binary(max_size=3000))
def test_a_batch_of_frames_survives_unchanged(batch: bytes) -> None:
    data = convert.encode_batch(batch)

    assert data == from_middleware(data, UInt8MultiArray)
    assert convert.decode_batch(data) == batch


@pytest.mark.parametrize(
    "decode",
    [
        convert.decode_imu,
        convert.decode_fix,
        convert.decode_ranges,
        convert.decode_proximity,
        convert.decode_command,
        convert.decode_batch,
    ],
)
@given(data=st.binary(max_size=400))
def test_arbitrary_bytes_are_refused_or_read_but_never_crash(decode: Any, data: bytes) -> None:
    try:
        decode(cdr.ENCAPSULATION + data)
    except cdr.MessageError:
        return


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    ("part", "axis"),
    [
        ("orientation", "z"),
        ("orientation", "w"),
        ("angular_velocity", "z"),
        ("linear_acceleration", "x"),
        ("linear_acceleration", "y"),
    ],
)
def test_an_imu_message_that_is_not_finite_is_refused(part: str, axis: str, number: float) -> None:
    message = deserialize_message(convert.encode_imu(cdr.stamp(0.0), "", ImuSample(np.zeros(2), 0.25, 0.0)), Imu)
    setattr(getattr(message, part), axis, number)

    with pytest.raises(cdr.MessageError, match="finite"):
        convert.decode_imu(serialize_message(message))


def test_a_command_that_is_not_finite_is_refused() -> None:
    data = convert.encode_command(cdr.stamp(0.0), "", VelocityCommand(math.nan, 0.0))

    with pytest.raises(cdr.MessageError, match="finite"):
        convert.decode_command(data)
