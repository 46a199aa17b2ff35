"""The silhouette of a picture: its opaque part, or what is dark (or light, where the border is dark)."""

from __future__ import annotations

from pathlib import Path

import contourpy
import numpy as np
import shapely
from PIL import Image
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from mission_computer.shape.filling import polygonal
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray

SIDE_MAX = 1024  # [pixels]; a contour of 128 vertices cannot tell more detail than this
PIXELS_MAX = 50_000_000  # a larger picture is a mistake, or an attack on the memory
TRANSPARENT_MIN = 0.01  # share of the pixels; a picture with less transparency is not meant to have any
LEVEL = 0.5  # between background (0) and figure (1)


def bitmap_region(path: Path) -> BaseGeometry:
    """Return the silhouette in a picture, y upward, in pixels.

    In a picture with transparency it is the opaque part; else what is darker than medium brightness, or lighter if most
    of the border is dark. Where an edge is smooth, its outline lies between pixels.

    Raises
    ------
    ShapeError
        If the file is no picture, or shows nothing.
    """
    try:
        with Image.open(path) as image:
            if image.width * image.height > PIXELS_MAX:
                raise ShapeError(f"{path}: {image.width} x {image.height} pixels are too many; make it smaller")
            image.thumbnail((SIDE_MAX, SIDE_MAX), reducing_gap=2.0)
            figure = _figure(image)
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise ShapeError(f"{path}: not a readable picture ({type(error).__name__}); give PNG or SVG") from None
    region = _traced(figure)
    if region.is_empty:
        raise ShapeError(f"{path}: the picture shows no figure; draw it dark on white, or on a transparent background")
    return region


def _figure(image: Image.Image) -> FloatArray:
    """Return how much each pixel belongs to the figure, (h, w) from 0 to 1."""
    opacity = np.asarray(image.convert("RGBA").getchannel("A"), dtype=np.float64) / 255.0
    if np.mean(opacity < LEVEL) > TRANSPARENT_MIN:
        return opacity
    darkness = 1.0 - _brightness(image)
    border = np.concatenate([darkness[0], darkness[-1], darkness[:, 0], darkness[:, -1]])
    return 1.0 - darkness if np.median(border) > LEVEL else darkness


def _brightness(image: Image.Image) -> FloatArray:
    """Return the brightness of each pixel, (h, w) from 0 to 1."""
    if image.mode.startswith(("I", "F")):  # one channel of more than eight bits, which Pillow would cut off at 255
        values = np.asarray(image, dtype=np.float64)
        return values / max(float(values.max()), 1.0)
    return np.asarray(image.convert("L"), dtype=np.float64) / 255.0


def _traced(figure: FloatArray) -> BaseGeometry:
    """Return the region in which a (h, w) field is above `LEVEL`; its first row is at the top."""
    padded = np.pad(figure, 1)[::-1]  # so that what reaches the border has an outline there
    generator = contourpy.contour_generator(z=padded, fill_type=contourpy.FillType.OuterOffset)
    filling = generator.filled(LEVEL, np.inf)
    parts = []
    for points, cuts in zip(filling[0], filling[1], strict=True):
        assert points is not None  # contourpy has None where it was told to work in chunks
        assert cuts is not None
        outer, *holes = np.split(points, np.asarray(cuts)[1:-1].astype(int))
        parts.append(Polygon(outer, holes))
    return polygonal(shapely.make_valid(shapely.union_all(parts)))
