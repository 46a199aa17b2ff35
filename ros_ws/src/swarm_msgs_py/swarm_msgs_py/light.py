"""Codes of images and the light that they stand for (sRGB, IEC 61966-2-1).

In light, unlike in codes, a pixel that two colors share is the mean of both.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.types import FloatArray

CODES = 255.0


def linear_of(srgb: tuple[int, int, int]) -> FloatArray:
    """Return the linear light (3,), 0 to 1, that sRGB codes stand for."""
    return _linear(np.array(srgb) / CODES)


def _linear(share: FloatArray) -> FloatArray:
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


_LIGHT_OF_CODE = _linear(np.arange(CODES + 1.0) / CODES).astype(np.float32)


def light_of(codes: ImageArray) -> NDArray[np.float32]:
    """Return the linear light, 0 to 1, of whole sRGB codes of any shape."""
    light: NDArray[np.float32] = _LIGHT_OF_CODE[codes]
    return light
