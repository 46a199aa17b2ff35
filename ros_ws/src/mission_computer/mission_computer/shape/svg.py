"""The silhouette of an SVG drawing: what its shapes fill, with all transforms applied."""

from __future__ import annotations

import io
from collections.abc import Iterator
from xml.etree.ElementTree import ParseError

import numpy as np
import shapely
import svgelements
from shapely import Polygon
from shapely.errors import ShapelyError
from shapely.geometry.base import BaseGeometry

from mission_computer.shape.filling import FillRule, filled, polygonal
from mission_computer.shape.svg_tree import drawn_document
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

    Paths, basic shapes, groups, ``use`` and symbols, nested viewports, transforms, style sheets, holes and both fill
    rules count; what is hidden or fully transparent does not, nor do clips, masks and the width of strokes. White
    shapes erase what is below them, but in a drawing that is all white they are the figure. In a drawing that fills
    nothing, the insides of its outlines count.

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
        document = svgelements.SVG.parse(io.StringIO(drawn_document(text)), reify=True)
        shapes = list(_visible(document))
        region = _painted(shapes)
    except _DEFECTS as error:
        raise ShapeError(f"{name}: not a sound SVG drawing ({type(error).__name__}); export it again") from None
    if region is None:
        raise ShapeError(f"{name}: white covers all that the drawing fills; delete the white shapes on top")
    if region.is_empty:
        what = "has area; close its outlines, and" if shapes else "can be seen; show hidden layers, and"
        raise ShapeError(f"{name}: nothing in the drawing {what} convert texts and images in it to paths")
    return region


def _visible(element: svgelements.SVGElement) -> Iterator[svgelements.Shape]:
    """Yield the shapes of a tree that can be seen; what is in a transparent group cannot, whatever it says itself."""
    if _share(element.values.get("attributes", {}).get("opacity")) <= 0.0:
        return
    if isinstance(element, svgelements.Shape):
        if element.values.get("visibility") not in ("hidden", "collapse"):
            yield element
    elif isinstance(element, svgelements.Group):
        for child in element:
            yield from _visible(child)


def _painted(shapes: list[svgelements.Shape]) -> BaseGeometry | None:
    """Return what is left of the fills when all are painted in turn; None: only white."""
    fills = [(_area(shape), _color_of(shape)) for shape in shapes if _color_of(shape) is not None]
    fills = [(area, color) for area, color in fills if not area.is_empty]
    if all(color == WHITE for _, color in fills):  # a white logo for a dark page, or outlines only
        figure = [area for area, _ in fills] or [_area(shape) for shape in shapes if _is_stroked(shape)]
        return polygonal(shapely.union_all(figure))
    region: BaseGeometry = Polygon()
    for area, color in fills:
        region = region.difference(area) if color == WHITE else region.union(area)
    left = polygonal(region)
    return None if left.is_empty else left


def _area(shape: svgelements.Shape) -> BaseGeometry:
    return filled(list(_rings(abs(svgelements.Path(shape)))), _rule_of(shape))


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
    if fill is None or fill.value is None or fill.alpha == 0 or _share(shape.values.get("fill-opacity")) <= 0.0:
        return None
    return int(fill.value) >> 8


def _is_stroked(shape: svgelements.Shape) -> bool:
    stroke = shape.stroke
    return stroke is not None and stroke.value is not None and stroke.alpha != 0


def _share(text: str | None) -> float:
    """Return an opacity, written as a number or in percent; what is neither hides nothing."""
    try:
        number = float((text or "1").removesuffix("%"))
    except ValueError:
        return 1.0
    return number


def _rule_of(shape: svgelements.Shape) -> FillRule:
    rule = shape.values.get("fill-rule", FillRule.NONZERO.value)
    return FillRule.EVENODD if rule == FillRule.EVENODD.value else FillRule.NONZERO
