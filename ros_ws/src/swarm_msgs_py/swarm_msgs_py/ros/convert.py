"""Typed records to and from the messages that the lockstep exchanges, one pair of functions per channel.

All numbers survive the round trip unchanged, bit for bit: a run over ROS and the same run in one process give the same
trajectories. Encoded messages begin with a stamp that is made once per tick (`cdr.stamp`) and shared by all of them.
"""

from __future__ import annotations

import math
import struct

import numpy as np

from swarm_msgs_py.frames import Batch, unpack_batch
from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.orientation import quaternion_of, yaw_of
from swarm_msgs_py.ros import cdr
from swarm_msgs_py.types import FloatArray, IntArray, NodeId, robot_name

MAP_FRAME = "map"
"""The world frame (REP 105)."""

NEIGHBOR_LABELS = ("neighbor", "id_offset")
"""The same of a scan of neighbors in space: one row per robot, [address, x, y, z [m]] each."""

BOAT_LABELS = ("pose_reference", "x_y_yaw")
"""The same of a boat: measured pose, then the pose that the firmware holds, [x, y [m], yaw [rad]] each."""

RANGE_LABELS = ("neighbor", "id_range")
"""Labels of the two dimensions of a range scan: one row per neighbor, [address, range [m]] each."""

UNMEASURED_VARIANCE = 1e9  # of what a position sensor does not measure: height and orientation

_IMU = struct.Struct("<37d")  # quaternion 4, angular velocity 3, acceleration 3; each followed by its covariance 9
_UNKNOWN_COVARIANCE = (0.0,) * 9
_UNMEASURED = (-1.0, *(0.0,) * 8)
_FIX = struct.Struct("<43d")  # position 3, quaternion 4, covariance 36
_FIX_REST = tuple(UNMEASURED_VARIANCE if row == column else 0.0 for row in range(2, 6) for column in range(6))
_EXACT_PLACE = tuple(
    0.0 if row != column or row < 3 else UNMEASURED_VARIANCE for row in range(6) for column in range(6)
)
_TWIST = struct.Struct("<6d")


def body_frame(robot: NodeId) -> str:
    """Return the name of a robot's body frame: ``r07/base_link``."""
    return f"{robot_name(robot)}/base_link"


def tick_at(time: float, period_s: float) -> int:
    """Return the number of the tick that starts at `time` [s]."""
    return round(time / period_s)


def encode_imu(stamp: bytes, frame: str, sample: ImuSample) -> bytes:
    """Return a ``sensor_msgs/Imu``: heading as quaternion, planar rates and accelerations, covariances unknown.

    As the message's definition has it, a covariance that begins with -1 says that there is no heading.
    """
    z, w = (0.0, 1.0) if sample.yaw is None else quaternion_of(sample.yaw)
    heading = (z, w, *(_UNKNOWN_COVARIANCE if sample.yaw is not None else _UNMEASURED))
    forward, left = sample.acceleration_body.tolist()
    turning = (0.0, 0.0, sample.yaw_rate, *_UNKNOWN_COVARIANCE)
    numbers = (0.0, 0.0, *heading, *turning, forward, left, 0.0, *_UNKNOWN_COVARIANCE)
    return stamp + cdr.frame(frame) + _IMU.pack(*numbers)


def decode_imu(data: bytes) -> tuple[float, ImuSample]:
    """Return the time [s] and the sample of a ``sensor_msgs/Imu``.

    Raises
    ------
    MessageError
        If the message is cut short, or a number that is read from it is not finite.
    """
    time, at = cdr.read_header(data)
    numbers = cdr.read_doubles(data, _IMU, at)
    z, w, yaw_rate, forward, left = measured = (*numbers[2:4], numbers[15], *numbers[25:27])
    if not all(map(math.isfinite, measured)):
        raise cdr.MessageError(f"inertial sample must be finite, got {', '.join(map(str, measured))}")
    yaw = None if numbers[4] == _UNMEASURED[0] else yaw_of(z, w)
    return time, ImuSample(np.array([forward, left]), yaw, yaw_rate)


def encode_fix(stamp: bytes, fix: PositionFix) -> bytes:
    """Return a ``geometry_msgs/PoseWithCovarianceStamped`` whose height and orientation are unmeasured."""
    x, y = fix.position.tolist()
    variance = fix.sigma * fix.sigma  # its square root is `sigma` again, exactly: so binary floating point rounds
    covariance = (variance, *(0.0,) * 6, variance, *(0.0,) * 4, *_FIX_REST)
    return stamp + cdr.frame(MAP_FRAME) + _FIX.pack(x, y, 0.0, 0.0, 0.0, 0.0, 1.0, *covariance)


def decode_fix(data: bytes) -> tuple[float, PositionFix]:
    """Return the time [s] and the fix of a ``geometry_msgs/PoseWithCovarianceStamped``.

    Raises
    ------
    MessageError
        If the message is cut short, or its variance is negative.
    """
    time, at = cdr.read_header(data)
    numbers = cdr.read_doubles(data, _FIX, at)
    if not numbers[7] >= 0.0:
        raise cdr.MessageError(f"variance of a fix must be >= 0, got {numbers[7]:g}")
    return time, PositionFix(np.array(numbers[:2]), math.sqrt(numbers[7]))


def encode_ranges(tick: int, scan: RangeScan) -> bytes:
    """Return a ``std_msgs/Float64MultiArray``: the tick, then rows [neighbor, range]."""
    return cdr.double_array(np.column_stack((scan.neighbors, scan.ranges)), RANGE_LABELS, (float(tick),))


def decode_ranges(data: bytes) -> tuple[int, RangeScan]:
    """Return the tick and the scan of a ``std_msgs/Float64MultiArray``.

    Raises
    ------
    MessageError
        If it is not a table of two columns after one number.
    """
    leading, rows = cdr.read_double_array(data)
    if len(leading) != 1 or rows.shape[1] != 2:
        raise cdr.MessageError(f"range scan has {len(leading)} + n x {rows.shape[1]} numbers, not 1 + n x 2")
    return int(leading[0]), RangeScan(rows[:, 0].astype(np.int64), np.ascontiguousarray(rows[:, 1]))


def encode_proximity(stamp: bytes, frame: str, points: FloatArray) -> bytes:
    """Return a ``geometry_msgs/PoseArray`` with one pose per surface point, of no particular orientation."""
    poses = np.zeros((len(points), 7))
    poses[:, :2] = points
    poses[:, 6] = 1.0
    return cdr.pose_array(stamp, frame, poses)


def decode_proximity(data: bytes) -> tuple[float, FloatArray]:
    """Return the time [s] and the (n, 2) points of a ``geometry_msgs/PoseArray``.

    Raises
    ------
    MessageError
        If the message is cut short.
    """
    time, poses = cdr.read_pose_array(data)
    return time, np.ascontiguousarray(poses[:, :2])


def encode_command(stamp: bytes, frame: str, command: VelocityCommand) -> bytes:
    """Return a ``geometry_msgs/TwistStamped`` in the body frame."""
    return stamp + cdr.frame(frame) + _TWIST.pack(command.forward, command.left, 0.0, 0.0, 0.0, command.yaw_rate)


def decode_command(data: bytes) -> tuple[float, VelocityCommand]:
    """Return the time [s] and the command of a ``geometry_msgs/TwistStamped``.

    Raises
    ------
    MessageError
        If the message is cut short, or a number is not finite.
    """
    time, at = cdr.read_header(data)
    forward, left, _, _, _, yaw_rate = cdr.read_doubles(data, _TWIST, at)
    if not math.isfinite(forward + left + yaw_rate):
        raise cdr.MessageError(f"velocity command must be finite, got {forward}, {left}, {yaw_rate}")
    return time, VelocityCommand(forward, left, yaw_rate)


def encode_place(stamp: bytes, position: FloatArray) -> bytes:
    """Return a ``geometry_msgs/PoseWithCovarianceStamped`` of an exact position (3,) [m], of unmeasured orientation."""
    return stamp + cdr.frame(MAP_FRAME) + _FIX.pack(*position.tolist(), 0.0, 0.0, 0.0, 1.0, *_EXACT_PLACE)


def decode_place(data: bytes) -> tuple[float, FloatArray]:
    """Return the time [s] and the position (3,) [m] of a ``geometry_msgs/PoseWithCovarianceStamped``.

    Raises
    ------
    MessageError
        If the message is cut short, or a coordinate is not finite.
    """
    time, at = cdr.read_header(data)
    position = cdr.read_doubles(data, _FIX, at)[:3]
    if not all(map(math.isfinite, position)):
        raise cdr.MessageError(f"position must be finite, got {', '.join(map(str, position))}")
    return time, np.array(position)


def encode_neighbors(tick: int, ids: IntArray, offsets: FloatArray) -> bytes:
    """Return a ``std_msgs/Float64MultiArray``: the tick, then a row [robot, x, y, z] for each id and offset [m]."""
    return cdr.double_array(np.column_stack((ids, offsets)), NEIGHBOR_LABELS, (float(tick),))


def decode_neighbors(data: bytes) -> tuple[int, tuple[IntArray, FloatArray]]:
    """Return the tick, and the ids (n,) and offsets (n, 3) [m], of a ``std_msgs/Float64MultiArray``.

    Raises
    ------
    MessageError
        If it is not a table of four columns after one number.
    """
    leading, rows = cdr.read_double_array(data)
    if len(leading) != 1 or rows.shape[1] != 4:
        raise cdr.MessageError(f"neighbors have {len(leading)} + n x {rows.shape[1]} numbers, not 1 + n x 4")
    return int(leading[0]), (rows[:, 0].astype(np.int64), np.ascontiguousarray(rows[:, 1:]))


def encode_boat(tick: int, contacts: int, poses: FloatArray) -> bytes:
    """Return a ``std_msgs/Float64MultiArray``: tick, pressed foils as bits, then measured and held pose.

    Further rows are places of other hulls, (2 + k, 3).
    """
    return cdr.double_array(poses, BOAT_LABELS, (float(tick), float(contacts)))


def decode_boat(data: bytes) -> tuple[int, tuple[int, FloatArray]]:
    """Return the tick, the pressed foils as bits, and the poses (2 + k, 3), of a ``std_msgs/Float64MultiArray``.

    Raises
    ------
    MessageError
        If it is not such a table after two numbers, or a number is not finite.
    """
    leading, rows = cdr.read_double_array(data)
    if len(leading) != 2 or rows.ndim != 2 or rows.shape[0] < 2 or rows.shape[1] != 3:
        raise cdr.MessageError(f"a boat has {len(leading)} + {rows.shape} numbers, not 2 + (2 or more, 3)")
    if not (np.isfinite(leading).all() and np.isfinite(rows).all()):
        raise cdr.MessageError("the poses of a boat must be finite")
    return int(leading[0]), (int(leading[1]), rows)


def encode_drift(stamp: bytes, velocity: FloatArray) -> bytes:
    """Return a ``geometry_msgs/TwistStamped`` of a planar velocity (3,) in the world frame [m/s], [rad/s]."""
    x, y, turn = velocity.tolist()
    return stamp + cdr.frame(MAP_FRAME) + _TWIST.pack(x, y, 0.0, 0.0, 0.0, turn)


def decode_drift(data: bytes) -> tuple[float, FloatArray]:
    """Return the time [s] and the planar velocity (3,) of a ``geometry_msgs/TwistStamped``.

    Raises
    ------
    MessageError
        If the message is cut short, or a number is not finite.
    """
    time, at = cdr.read_header(data)
    twist = cdr.read_doubles(data, _TWIST, at)
    velocity = (twist[0], twist[1], twist[5])
    if not all(map(math.isfinite, velocity)):
        raise cdr.MessageError(f"velocity must be finite, got {', '.join(map(str, velocity))}")
    return time, np.array(velocity)


def encode_velocity(stamp: bytes, frame: str, velocity: FloatArray) -> bytes:
    """Return a ``geometry_msgs/TwistStamped`` of a velocity (3,) [m/s]."""
    return stamp + cdr.frame(frame) + _TWIST.pack(*velocity.tolist(), 0.0, 0.0, 0.0)


def decode_velocity(data: bytes) -> tuple[float, FloatArray]:
    """Return the time [s] and the velocity (3,) [m/s] of a ``geometry_msgs/TwistStamped``.

    Raises
    ------
    MessageError
        If the message is cut short, or a number is not finite.
    """
    time, at = cdr.read_header(data)
    velocity = cdr.read_doubles(data, _TWIST, at)[:3]
    if not all(map(math.isfinite, velocity)):
        raise cdr.MessageError(f"velocity must be finite, got {', '.join(map(str, velocity))}")
    return time, np.array(velocity)


def encode_batch(batch: bytes) -> bytes:
    """Return a ``std_msgs/UInt8MultiArray`` that holds a batch of radio frames."""
    return cdr.byte_array(batch)


def decode_batch(data: bytes) -> bytes:
    """Return the batch of a ``std_msgs/UInt8MultiArray``.

    Raises
    ------
    MessageError
        If the message is cut short.
    """
    return cdr.read_byte_array(data)


def decode_frames(data: bytes) -> Batch:
    """Return the radio frames of a ``std_msgs/UInt8MultiArray``, with tick and flags.

    Raises
    ------
    MessageError
        If the message is cut short.
    FrameError
        If what it holds is not a batch.
    """
    return unpack_batch(decode_batch(data))
