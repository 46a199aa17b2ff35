"""Length-checked reading and exact writing of little-endian binary records; shared by the frame and body codecs."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.types import FloatArray

COORDINATE_MAX = 1e6
"""Largest coordinate on the air [m]: more is no place of a robot, and as ``float32`` exact to no more than 6 cm."""


class Reader:
    """Reads a buffer from front to back and never beyond its end.

    Parameters
    ----------
    data : bytes
        Whole record.
    start, stop : int
        Part of `data` to read; `stop` None means its end.
    """

    def __init__(self, data: bytes, start: int = 0, stop: int | None = None) -> None:
        self._data = data
        self._at = start
        self._stop = len(data) if stop is None else stop

    def _advance(self, size: int) -> int:
        start = self._at
        if size > self._stop - start:
            raise FrameError(f"record ends early: {size} bytes wanted, {self._stop - start} left")
        self._at = start + size
        return start

    def fields(self, layout: struct.Struct) -> tuple[Any, ...]:
        """Return the next fields.

        Raises
        ------
        FrameError
            If the record is too short.
        """
        return layout.unpack_from(self._data, self._advance(layout.size))

    def array(self, dtype: DTypeLike, count: int) -> NDArray[Any]:
        """Return the next `count` items as a read-only view of the buffer.

        Raises
        ------
        FrameError
            If the record is too short.
        """
        kind = np.dtype(dtype)
        return np.frombuffer(self._data, kind, count, self._advance(kind.itemsize * count))

    def points(self, count: int) -> FloatArray:
        """Return the next `count` points as a read-only (count, 2) array.

        Raises
        ------
        FrameError
            If the record is too short or a coordinate is not finite, or absurd.
        """
        return frozen(checked(self.array("<f4", 2 * count).astype(np.float64).reshape(count, 2)))

    def rest(self) -> bytes:
        """Return all that is left."""
        size = self._stop - self._at
        start = self._advance(size)
        return self._data[start : start + size]

    def left(self) -> int:
        """Return the number of bytes left."""
        return self._stop - self._at

    def finish(self) -> None:
        """Check that everything was read.

        Raises
        ------
        FrameError
            If bytes are left over.
        """
        if self._at != self._stop:
            raise FrameError(f"record has {self._stop - self._at} bytes too many")


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return `array`, made read-only: decoded records are shared between receivers."""
    array.flags.writeable = False
    return array


def checked(coordinates: FloatArray) -> FloatArray:
    """Return `coordinates` [m].

    Raises
    ------
    FrameError
        If one of them is not finite or beyond `COORDINATE_MAX`.
    """
    if not (np.abs(coordinates) <= COORDINATE_MAX).all():  # false for NaN as well
        raise FrameError(f"a coordinate is not finite, or beyond {COORDINATE_MAX:g} m")
    return coordinates


def packed(layout: struct.Struct, *fields: object) -> bytes:
    """Return the fields as bytes.

    Raises
    ------
    FrameError
        If a field does not fit its place in the layout.
    """
    try:
        return layout.pack(*fields)
    except (struct.error, OverflowError) as error:
        raise FrameError(f"field does not fit: {error}") from None


def packed_points(points: ArrayLike) -> bytes:
    """Return points as pairs of little-endian ``float32`` [m].

    Raises
    ------
    FrameError
        If a coordinate is not finite or beyond `COORDINATE_MAX`.
    """
    return checked(np.asarray(points, dtype=np.float64).reshape(-1, 2)).astype("<f4").tobytes()


def packed_integers(values: ArrayLike | Sequence[int], dtype: str) -> bytes:
    """Return integers as little-endian items of `dtype`.

    Raises
    ------
    FrameError
        If one is outside the range of `dtype`.
    """
    array = np.asarray(values, dtype=np.int64)
    limits = np.iinfo(dtype)
    if array.size and (array.min() < limits.min or array.max() > limits.max):
        raise FrameError(f"a value is outside {limits.min}..{limits.max}")
    return array.astype(dtype).tobytes()
