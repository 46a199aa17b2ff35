"""From closed outlines, as drawings have them, to the region that they fill."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.types import FloatArray


class FillRule(Enum):
    """What is inside of outlines that cross or contain each other, by the number of turns around a point."""

    NONZERO = "nonzero"
    EVENODD = "evenodd"


def filled(rings: Sequence[FloatArray], rule: FillRule) -> BaseGeometry:
    """Return the region that closed outlines fill; they may cross themselves and each other.

    Parameters
    ----------
    rings : sequence of (k, 2) array
        Vertices, the first one repeated at the end or not.
    rule : FillRule

    Returns
    -------
    shapely geometry
        Valid; empty if the outlines enclose nothing.
    """
    closed = [np.vstack([ring, ring[:1]]) for ring in rings if len(ring) >= 3]
    if not closed:
        return Polygon()
    noded = shapely.node(shapely.MultiLineString(closed))  # cut wherever lines meet, so that faces can be told apart
    faces = shapely.get_parts(shapely.polygonize([noded]))
    inside = [face for face in faces if _is_inside(_turns_around(shapely.point_on_surface(face), closed), rule)]
    return polygonal(shapely.union_all(inside))


def polygonal(region: BaseGeometry) -> BaseGeometry:
    """Return the part of a region that has area: set operations leave lines and points behind."""
    parts = [part for part in shapely.get_parts(region) if isinstance(part, Polygon) and part.area]
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def _turns_around(point: shapely.Point, rings: Sequence[FloatArray]) -> int:
    """Return how often the rings wind around a point that is on none of them, counter-clockwise."""
    x, y = point.x, point.y
    turns = 0
    for ring in rings:
        (x0, y0), (x1, y1) = ring[:-1].T, ring[1:].T
        upward, downward = (y0 <= y) & (y1 > y), (y1 <= y) & (y0 > y)
        side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)  # > 0: the point is to the left of the edge
        turns += int((upward & (side > 0.0)).sum()) - int((downward & (side < 0.0)).sum())
    return turns


def _is_inside(turns: int, rule: FillRule) -> bool:
    return turns != 0 if rule is FillRule.NONZERO else turns % 2 == 1
