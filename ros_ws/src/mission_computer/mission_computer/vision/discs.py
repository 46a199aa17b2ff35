"""From a colored blob to a disc in the arena: middle to a few hundredths of a pixel, radius, and how round it is.

A pixel on the edge is a mixture of disc and surroundings; in linear light its share of the disc follows from the two
colors. Moments of these shares over the plane of the cover, instead of over pixels, are free of bias from the lens and
the perspective, and need no undistorted image.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from mission_computer.vision.calibration import PlaneMap
from mission_computer.vision.colors import Blob
from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.light import light_of
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.types import FloatArray

PAD_PX = 4
EDGE = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
"""Reaches the farthest pixels of which a disc may cover a part that is too small for their color to show."""
SURROUNDINGS = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (7, 7))
CORE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))
LEAST_CORE_PX = 4
"""Fewer pixels that the disc covers whole do not give its color; then the whole blob does."""
DIM = 1e-3
"""Light below which nothing can be told [of 1]."""
LEAST_MOMENT = 1e-9
"""Least second moment [m^2]: a line of pixels has none across, but for rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Disc:
    """A blob, measured as if it were a disc at the height of the cover.

    Attributes
    ----------
    color : MarkerColor
    center : (2,) array
        World frame [m].
    radius : float
        Of the disc of equal area [m].
    elongation : float
        Ratio of the axes of the ellipse of equal moments, at least 1.
    solidity : float
        Area, relative to that ellipse: 1 for a disc or an ellipse, less for any other form. Both without blur.
    backing : float
        Brightness of the surroundings, relative to the disc.
    is_cut : bool
        It ends at the border of the image or of a part that shows nothing.
    pixel_m : float
        Side of a pixel in its middle [m].
    """

    color: MarkerColor
    center: FloatArray
    radius: float
    elongation: float
    solidity: float
    backing: float
    is_cut: bool
    pixel_m: float


def measure(blob: Blob, pixels: ImageArray, largest: ImageArray, plane: PlaneMap, config: VisionConfig) -> Disc | None:
    """Return the disc that a blob is.

    Parameters
    ----------
    blob : Blob
    pixels : (h, w, 3) uint8 array
    largest : (h, w) uint8 array
        Largest channel of each pixel.
    plane : PlaneMap
        Of the height of covers of that color.
    config : VisionConfig

    Returns
    -------
    Disc or None
        None if the blob does not differ from its surroundings.
    """
    (top, bottom), (left, right) = blob.rows, blob.columns
    height, width = largest.shape
    rows = slice(max(top - PAD_PX, 0), min(bottom + PAD_PX, height))
    columns = slice(max(left - PAD_PX, 0), min(right + PAD_PX, width))
    mask = np.zeros((rows.stop - rows.start, columns.stop - columns.start), dtype=np.uint8)
    mask[top - rows.start : bottom - rows.start, left - columns.start : right - columns.start] = blob.mask
    region = cv2.dilate(mask, EDGE)
    around = cv2.dilate(mask, SURROUNDINGS) > region
    touches = top == 0 or left == 0 or bottom == height or right == width
    is_dead = (largest[rows, columns] <= config.dead_code) & (around | (region > 0))

    light = light_of(pixels[rows, columns])
    core = cv2.erode(mask, CORE, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
    if core.sum() < LEAST_CORE_PX:
        core = mask > 0
    inside = light[core].mean(axis=0)
    outside = np.median(light[around], axis=0) if around.any() else np.zeros(3, dtype=np.float32)
    # Only what is colored about the disc counts: the light floor beyond the black rim of a cover then weighs nothing.
    contrast = inside - outside
    contrast -= contrast.mean()
    power = float(contrast @ contrast)
    if power < DIM**2:
        return None
    shares = np.clip((light - outside) @ (contrast / power), 0.0, 1.0) * region
    points, areas = plane.window(rows, columns)
    moments = _moments(shares * areas, points)
    pixel = float(areas.mean())
    # Spreading each point over a square adds its second moment, along every axis.
    small, large = (max(moment - config.spot_px**2 / 12.0 * pixel, LEAST_MOMENT) for moment in moments.axes)
    return Disc(
        color=blob.color,
        center=moments.center,
        radius=float(np.sqrt(moments.area / np.pi)),
        elongation=float(np.sqrt(large / small)),
        solidity=moments.area / (4.0 * np.pi * float(np.sqrt(small * large))),
        backing=float(outside.max() / inside.max()),
        is_cut=touches or bool(is_dead.any()),
        pixel_m=float(np.sqrt(pixel)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Moments:
    """Area [m^2], centroid (2,) [m], and the second moments about it along the short and the long axis [m^2]."""

    area: float
    center: FloatArray
    axes: tuple[float, float]


def _moments(weights: FloatArray, points: FloatArray) -> _Moments:
    """Return the moments of weights (h, w) at points (h, w, 2)."""
    area = float(weights.sum())
    shares = (weights / area).ravel()
    places = points.reshape(-1, 2)
    center: FloatArray = shares @ places
    off = places - center
    spread = (off * shares[:, None]).T @ off
    mean = float(spread[0, 0] + spread[1, 1]) / 2.0
    gap = float(np.hypot((spread[0, 0] - spread[1, 1]) / 2.0, spread[0, 1]))
    return _Moments(area, center, (mean - gap, mean + gap))
