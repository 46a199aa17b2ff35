"""The silhouette of an SVG drawing: what its shapes fill, with all transforms applied."""

from __future__ import annotations

import io
from collections.abc import Iterator
from xml.etree.ElementTree import ParseError

import numpy as np
import svgelements
from shapely.errors import ShapelyError
from shapely.geometry.base import BaseGeometry

from mission_computer.shape.filling import FillRule, filled, polygonal
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray

CURVE_POINTS = 24  # per curved segment; a full circle has four, and a contour at most 128 vertices
WHITE = 0xFFFFFF
_DEFECTS = (
    *(ParseError, ValueError, KeyError, IndexError, TypeError, AttributeError, ArithmeticError, RecursionError),
    ShapelyError,
)
"""What the parser raises on files that are no SVG, or not a sound one."""


def svg_region(text: str, name: str) -> BaseGeometry:
    """Return what a drawing fills, y upward, in its own units.

    Paths, basic shapes, groups, ``use``, transforms, ``viewBox``, holes and both fill rules count; strokes have no
    width. White shapes erase what is below them. In a drawing that fills nothing, the insides of its outlines count.

    Parameters
    ----------
    text : str
        The SVG document.
    name : str
        What to call it in errors.

    Raises
    ------
    ShapeError
        If it is no SVG, or nothing in it has area.
    """
    try:
        document = svgelements.SVG.parse(io.StringIO(text), reify=True)
        shapes = [shape for shape in document.elements() if isinstance(shape, svgelements.Shape)]
        painted = [shape for shape in shapes if _color_of(shape) is not None]
        region = _painted(painted or shapes)
    except _DEFECTS as error:
        raise ShapeError(f"{name}: not a sound SVG drawing ({type(error).__name__}); export it again") from None
    if region.is_empty:
        raise ShapeError(f"{name}: nothing in the drawing has area; convert texts and images in it to paths")
    return region


def _painted(shapes: list[svgelements.Shape]) -> BaseGeometry:
    region = filled((), FillRule.NONZERO)
    for shape in shapes:
        area = filled(list(_rings(abs(svgelements.Path(shape)))), _rule_of(shape))
        region = region.difference(area) if _color_of(shape) == WHITE else region.union(area)
    return polygonal(region)


def _rings(path: svgelements.Path) -> Iterator[FloatArray]:
    """Yield the outline of each sub-path, curves as chords."""
    for part in path.as_subpaths():
        points: list[tuple[float, float]] = []
        for segment in part:
            if isinstance(segment, svgelements.Move):
                points.append((segment.end.x, segment.end.y))
            elif isinstance(segment, svgelements.Line | svgelements.Close):
                if segment.end is not None:
                    points.append((segment.end.x, segment.end.y))
            else:
                shares = np.linspace(0.0, 1.0, CURVE_POINTS + 1)[1:]
                points += [(point.x, point.y) for point in map(segment.point, shares.tolist())]
        if len(points) >= 3:
            yield np.array(points, dtype=np.float64) * (1.0, -1.0)  # pictures have y downward


def _color_of(shape: svgelements.Shape) -> int | None:
    """Return the RGB color that a shape is filled with; None: it is not."""
    fill = shape.fill
    if fill is None or fill.value is None or fill.alpha == 0:
        return None
    return int(fill.value) >> 8


def _rule_of(shape: svgelements.Shape) -> FillRule:
    rule = shape.values.get("fill-rule", FillRule.NONZERO.value)
    return FillRule.EVENODD if rule == FillRule.EVENODD.value else FillRule.NONZERO
