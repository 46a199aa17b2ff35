"""From the light that falls on the sensor to the codes of an image: sRGB, illumination, noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from swarm_msgs_py.light import CODES
from swarm_msgs_py.messages.camera import ImageArray
from swarm_sim.config import CameraConfig

LightArray = NDArray[np.float32]
TABLE_SIZE = 4096
"""Entries of the table of codes over light 0 to 1; its steps are below half a code where light is not almost black."""
NORMAL_SIZE = 65536


def _code_table() -> LightArray:
    light = np.linspace(0.0, 1.0, TABLE_SIZE)
    share = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    return (CODES * share).astype(np.float32)


_CODES_OF_LIGHT = _code_table()


_NORMAL = ndtri((np.arange(NORMAL_SIZE) + 0.5) / NORMAL_SIZE).astype(np.float32)
"""Equally likely values of a standard normal: drawing from them is four times as fast as drawing normals."""


def codes_of(light: LightArray) -> LightArray:
    """Return sRGB codes, not rounded, of linear light; light above 1 saturates."""
    places = np.clip(light * np.float32(TABLE_SIZE - 1) + np.float32(0.5), 0, TABLE_SIZE - 1).astype(np.int16)
    codes: LightArray = _CODES_OF_LIGHT[places]
    return codes


def illumination(config: CameraConfig, rng: np.random.Generator) -> LightArray:
    """Return the light on each pixel and channel (height, width, 3), 1 in the middle of the image on average.

    A lamp on one side (the side is drawn), a lens that darkens the corners, and a white balance that is a little off.

    Parameters
    ----------
    config : CameraConfig
    rng : Generator
    """
    half = max(config.width_px, config.height_px) / 2.0
    x = (np.arange(config.width_px) - (config.width_px - 1) / 2.0) / half
    y = ((np.arange(config.height_px) - (config.height_px - 1) / 2.0) / half)[:, None]
    side = rng.uniform(0.0, 2.0 * np.pi)
    slope = 1.0 + config.light_gradient * (np.cos(side) * x + np.sin(side) * y)
    wide, high = (size / max(config.width_px, config.height_px) for size in (config.width_px, config.height_px))
    corner = 1.0 - config.vignette * (x**2 + y**2) / (wide**2 + high**2)
    tint = 1.0 + config.tint_sigma * rng.normal(size=3)
    light = np.maximum(slope * corner, 0.0)[:, :, None] * tint
    shining: LightArray = light.astype(np.float32)
    return shining


def digitize(codes: LightArray, noise_codes: float, rng: np.random.Generator) -> ImageArray:
    """Return an image of codes (h, w, 3) with pixel noise, rounded to whole codes."""
    if noise_codes > 0.0:
        draws = rng.integers(0, len(_NORMAL), codes.size, dtype=np.uint16)
        noise = _NORMAL.take(draws).reshape(codes.shape)
        noise *= np.float32(noise_codes)
        codes = np.add(noise, codes, out=noise)
    # cv2 is not needed here: adding a half and cutting is rounding, for what was clipped to the codes.
    image: ImageArray = np.clip(codes + np.float32(0.5), 0, CODES).astype(np.uint8)
    return image
