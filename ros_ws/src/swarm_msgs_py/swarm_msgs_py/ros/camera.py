"""Images and what is known of the camera that took them, to and from their messages.

An image is nearly a megabyte, ten times a second: it is packed and read as bytes, without a message object in between
(see `cdr`). What the maker says of the camera is an ordinary message beside each.
"""

from __future__ import annotations

import struct

import numpy as np
from builtin_interfaces.msg import Time
from sensor_msgs.msg import CameraInfo as CameraInfoMessage
from std_msgs.msg import Header

from swarm_msgs_py.messages.camera import CameraImage, CameraInfo, ImageArray
from swarm_msgs_py.ros import cdr

CAMERA_FRAME = "camera"
"""Optical frame of the overhead camera."""

ENCODING = "rgb8"
MODEL = "plumb_bob"
CHANNELS = 3

_SIZE = struct.Struct("<II")  # height, width
_COUNT = struct.Struct("<I")
_BASE = len(cdr.ENCAPSULATION)


def encode_image(image: CameraImage) -> bytes:
    """Return a ``sensor_msgs/Image`` of encoding ``rgb8``."""
    height, width, _ = image.pixels.shape
    text = ENCODING.encode() + b"\0"
    head = cdr.stamp(image.time) + cdr.frame(CAMERA_FRAME, _SIZE.size // 2) + _SIZE.pack(height, width)
    head += _COUNT.pack(len(text)) + text + b"\0"  # not big-endian
    head += bytes(-(len(head) - _BASE) % _COUNT.size)
    data = np.ascontiguousarray(image.pixels).tobytes()
    return b"".join((head, _COUNT.pack(CHANNELS * width), _COUNT.pack(len(data)), data))


def decode_image(data: bytes) -> CameraImage:
    """Return the image of a ``sensor_msgs/Image``; its pixels are read-only.

    Raises
    ------
    MessageError
        If the message is cut short, or in another encoding.
    """
    time, at = cdr.read_header(data, _SIZE.size // 2)
    try:
        height, width = _SIZE.unpack_from(data, at)
        at += _SIZE.size
        (length,) = _COUNT.unpack_from(data, at)
        encoding = data[at + _COUNT.size : at + _COUNT.size + length - 1]
        at += _COUNT.size + length + 1
        at += -(at - _BASE) % _COUNT.size
        step, count = _SIZE.unpack_from(data, at)
    except struct.error as error:
        raise cdr.MessageError(f"image of {len(data)} bytes ends within its fields") from error
    at += _SIZE.size
    if encoding != ENCODING.encode():
        raise cdr.MessageError(f"image of encoding {encoding!r}, expected {ENCODING}")
    if step != CHANNELS * width or count != step * height or len(data) < at + count:
        raise cdr.MessageError(f"image of {width} x {height} pixels carries {count} bytes in rows of {step}")
    pixels: ImageArray = np.frombuffer(data, np.uint8, count, at).reshape(height, width, CHANNELS)
    return CameraImage(time, pixels)


def info_message(info: CameraInfo, stamp: Time) -> CameraInfoMessage:
    """Return a ``sensor_msgs/CameraInfo`` of the image with this stamp."""
    message = CameraInfoMessage(header=Header(stamp=stamp, frame_id=CAMERA_FRAME), height=info.height, width=info.width)
    message.distortion_model = MODEL
    message.d = info.distortion.tolist()
    message.k = info.intrinsics.ravel()
    message.r = np.eye(3).ravel()
    message.p = np.column_stack((info.intrinsics, np.zeros(3))).ravel()
    return message


def info_of(message: CameraInfoMessage) -> CameraInfo:
    """Return what a ``sensor_msgs/CameraInfo`` says.

    Raises
    ------
    MessageError
        If it is of another lens model.
    """
    if message.distortion_model != MODEL or len(message.d) != 5:
        raise cdr.MessageError(f"camera of model '{message.distortion_model}', expected {MODEL} with 5 numbers")
    intrinsics = np.array(message.k, dtype=np.float64).reshape(3, 3)
    return CameraInfo(message.width, message.height, intrinsics, np.array(message.d, dtype=np.float64))
