"""Which pixels have the color of a robot, in any light.

A change of brightness multiplies linear light by one factor; CIELAB's a*, b* and (almost) L* are homogeneous of degree
1/3 in it. So hue angle and chroma per lightness do not depend on how bright a part of the arena is, nor on how much of
a pixel lies on the black cover.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mission_computer.vision.config import VisionConfig
from mission_computer.vision.resolution import scale_of
from swarm_msgs_py.markers import PRINTED_SRGB, MarkerColor
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.types import BoolArray

LIGHTNESS_FLOOR = 1.0
"""Added to L* where it divides [CIELAB units]: below it, CIELAB is linear and hue is noise."""
LEAST_AREA_PX = 4
"""Fewer pixels than these are noise, however coarse the image."""


@dataclass(frozen=True, slots=True, eq=False)
class Blob:
    """Connected pixels of one color.

    Attributes
    ----------
    color : MarkerColor
    rows, columns : (start, stop)
        Bounding box.
    mask : (rows, columns) bool array
        The pixels, inside the bounding box.
    """

    color: MarkerColor
    rows: tuple[int, int]
    columns: tuple[int, int]
    mask: BoolArray


class ColorClassifier:
    """Finds blobs of the given colors.

    Parameters
    ----------
    config : VisionConfig
    colors : sequence of MarkerColor
        What to look for.
    """

    def __init__(self, config: VisionConfig, colors: Sequence[MarkerColor]) -> None:
        self._config, self._colors = config, tuple(colors)
        printed = np.array([PRINTED_SRGB[color] for color in MarkerColor], dtype=np.uint8)
        # All colors take part, also those that nobody wears: what is nearest to another color is no disc of ours.
        self._hues, _ = hue_and_saturation(printed)
        self._rank = {color: number for number, color in enumerate(MarkerColor)}

    def blobs(self, pixels: ImageArray) -> tuple[list[Blob], ImageArray]:
        """Return the colored blobs of an image, by color and then by place, and the largest channel of each pixel.

        Parameters
        ----------
        pixels : (h, w, 3) uint8 array
        """
        red, green, blue = cv2.split(pixels)
        largest = cv2.max(cv2.max(red, green), blue)
        spread = cv2.subtract(largest, cv2.min(cv2.min(red, green), blue))
        _, is_colored = cv2.threshold(spread, self._config.spread_min_codes - 1, 1, cv2.THRESH_BINARY)
        places = np.flatnonzero(is_colored)
        labels = self._labels(pixels.reshape(-1, 3)[places])
        rows, columns = np.divmod(places, pixels.shape[1])
        found = []
        least = max(self._config.area_min_px * scale_of(len(pixels)) ** 2, LEAST_AREA_PX)
        for color in self._colors:
            chosen = labels == self._rank[color]
            found += list(self._connected(color, rows[chosen], columns[chosen], least))
        return found, np.asarray(largest, dtype=np.uint8)

    def _labels(self, codes: ImageArray) -> NDArray[np.int64]:
        """Return the number of the color of each pixel (n, 3), -1 for those that have none."""
        if not len(codes):
            return np.empty(0, dtype=np.int64)
        hues, saturations = hue_and_saturation(codes)
        off = np.abs((hues[:, None] - self._hues + np.pi) % (2.0 * np.pi) - np.pi)
        nearest = off.argmin(axis=1)
        fits = off[np.arange(len(off)), nearest] <= self._config.hue_tolerance_rad
        return np.where(fits & (saturations >= self._config.saturation_min), nearest, -1)

    def _connected(
        self, color: MarkerColor, rows: NDArray[np.int64], columns: NDArray[np.int64], least: float
    ) -> Iterator[Blob]:
        """Yield the connected parts of the pixels of one color that have at least so many pixels."""
        if not len(rows):
            return
        top, left = int(rows.min()), int(columns.min())
        mask = np.zeros((int(rows.max()) - top + 1, int(columns.max()) - left + 1), dtype=np.uint8)
        mask[rows - top, columns - left] = 1
        count, parts, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
        for number in range(1, count):
            x, y, wide, high, area = (int(value) for value in stats[number])
            if area >= least:
                part = parts[y : y + high, x : x + wide] == number
                yield Blob(color, (top + y, top + y + high), (left + x, left + x + wide), part)


def hue_and_saturation(codes: ImageArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return hue angles [rad] and chroma per lightness of sRGB codes (n, 3), both (n,), in CIELAB."""
    srgb = (codes.astype(np.float32) / np.float32(255.0)).reshape(1, -1, 3)
    lab = cv2.cvtColor(srgb, cv2.COLOR_RGB2LAB)[0].astype(np.float64)
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    return np.arctan2(lab[:, 2], lab[:, 1]), chroma / (lab[:, 0] + LIGHTNESS_FLOOR)
