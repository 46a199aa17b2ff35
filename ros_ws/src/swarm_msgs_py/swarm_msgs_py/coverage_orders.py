"""What the operator orders the leader of a covering swarm: a frame that robots flood and the leader alone obeys."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from swarm_msgs_py.binary import Reader, checked, packed
from swarm_msgs_py.errors import FrameError

ORDER_VERSION = 0x81  # first byte of an order; frames among robots begin with their own
_ORDER = struct.Struct("<BHfffH")  # version, number, velocity, length of the shape

Velocity = tuple[float, float, float]
AT_REST: Velocity = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class CoverageOrder:
    """What the operator tells the leader.

    Attributes
    ----------
    number : int
        1, 2, ...; a higher one comes after a lower one.
    shape : bytes
        Packed description of the shape to cover (`geometry.solids.description`); empty: the one that is covered.
    velocity : tuple of float
        With which the whole formation, shape included, shall move from now on [m/s].
    """

    number: int
    shape: bytes = b""
    velocity: Velocity = AT_REST


def encode_order(order: CoverageOrder) -> bytes:
    """Return the frame of an order.

    Raises
    ------
    FrameError
        If a field does not fit, as the description of a mesh of very many faces.
    """
    return packed(_ORDER, ORDER_VERSION, order.number, *order.velocity, len(order.shape)) + order.shape


def is_order(data: bytes) -> bool:
    """Return whether a frame says that it is an order."""
    return data[:1] == bytes([ORDER_VERSION])


@lru_cache(maxsize=64)
def decode_order(data: bytes) -> CoverageOrder:
    """Return the order that a frame stands for.

    Raises
    ------
    FrameError
        If `data` is not exactly one order.
    """
    reader = Reader(data)
    version, number, x, y, z, size = reader.fields(_ORDER)
    if version != ORDER_VERSION:
        raise FrameError(f"an order of version {version}")
    checked(np.array([x, y, z]))
    shape = bytes(reader.array("u1", size))
    reader.finish()
    return CoverageOrder(number, shape, (x, y, z))
