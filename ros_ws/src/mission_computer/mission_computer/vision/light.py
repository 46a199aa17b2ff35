"""From the codes of an image back to light, in which a half-covered pixel is halfway between its two colors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.messages.camera import ImageArray

CODES = 255.0


def _table() -> NDArray[np.float32]:
    share = np.arange(CODES + 1.0) / CODES
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return light.astype(np.float32)


_LIGHT_OF_CODE = _table()


def linear_light(codes: ImageArray) -> NDArray[np.float32]:
    """Return the linear light, 0 to 1, of sRGB codes of any shape (IEC 61966-2-1)."""
    light: NDArray[np.float32] = _LIGHT_OF_CODE[codes]
    return light
