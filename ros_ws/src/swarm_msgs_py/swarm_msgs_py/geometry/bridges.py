"""Shapes of several parts, or with holes, as one simple contour.

Bridges too narrow for any robot join the parts, slits as narrow open the holes to the outside. For whoever orders such
a shape: the stages of a scenario, and what reads drawings. What comes after that takes it as any other contour.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray

BRIDGE_M = 0.02  # [m]; no goal fits in, and the area does not count
BISECTIONS = 60  # of twice the perimeter: to the last bit


def bridged(parts: Sequence[FloatArray]) -> FloatArray:
    """Return one simple contour around all parts, each joined where it is nearest to those before it.

    Parameters
    ----------
    parts : sequence of (k, 2) array
        Simple contours, at least one [m].

    Returns
    -------
    (m, 2) array
        Counter-clockwise [m].

    Raises
    ------
    ShapeError
        If parts overlap or touch, or a bridge would enclose a hole.
    """
    whole = Polygon(parts[0])
    for part in parts[1:]:
        other = Polygon(part)
        if whole.distance(other) < BRIDGE_M:
            raise ShapeError(f"two parts of the shape are less than {BRIDGE_M:g} m apart; move them apart")
        whole = shapely.union_all([whole, other, _bridge(whole, other)])
        if not isinstance(whole, Polygon) or whole.interiors:
            raise ShapeError(
                "a bridge between parts of the shape would enclose a hole; give the parts in another order"
            )
    return _outline(whole)


def one_contour(region: Polygon | MultiPolygon) -> FloatArray:
    """Return one simple contour around a region that may have several parts, and holes.

    Each hole is opened by a slit of `BRIDGE_M` where it is nearest to what is outside, each part is joined by a bridge
    of that width where it is nearest to the others.

    Parameters
    ----------
    region : shapely polygon or multi-polygon
        Valid, not empty [m].

    Returns
    -------
    (m, 2) array
        Counter-clockwise [m]; four vertices more per hole and per part after the first, as a rule.

    Raises
    ------
    ShapeError
        If parts, or a hole and what is outside, are nearer to each other than `BRIDGE_M`.
    """
    first, *others = (_outline(_opened(part)) for part in shapely.get_parts(region))
    ordered, whole = [first], Polygon(first)
    while others:  # the nearest part first, so that no bridge crosses another part
        nearest = min(range(len(others)), key=lambda k: (Polygon(others[k]).distance(whole), k))
        ordered.append(others.pop(nearest))
        whole = shapely.union_all([Polygon(part) for part in ordered])
    return bridged(ordered)


def _opened(part: Polygon) -> Polygon:
    """Return a polygon without holes: each is opened to the outside by a slit, those nearest to it first."""
    while part.interiors:
        outside = shapely.envelope(part).buffer(1.0).difference(Polygon(part.exterior))
        holes = [Polygon(ring) for ring in part.interiors]
        hole = min(holes, key=lambda candidate: float(candidate.distance(outside)))
        if hole.distance(outside) < BRIDGE_M:
            x, y = hole.representative_point().coords[0]
            raise ShapeError(
                f"the hole at ({x:.2f}, {y:.2f}) is less than {BRIDGE_M:g} m from the edge of the shape; scale it up,"
                " or close the hole"
            )
        opened = part.difference(_bridge(hole, outside))
        if not isinstance(opened, Polygon) or len(opened.interiors) >= len(part.interiors):
            raise ShapeError("a slit from a hole to the outside would cut the shape in two; close the hole")
        part = opened
    return part


def _bridge(one: Polygon, other: Polygon) -> Polygon:
    """Return a strip between two polygons, in the middle of where they are nearest, reaching a little into both."""
    facing = one.intersection(other.buffer(one.distance(other) + BRIDGE_M))
    middle = shapely.shortest_line(facing.centroid, one).interpolate(1.0, normalized=True)
    line = shapely.get_coordinates(shapely.shortest_line(middle, other))
    overlap = BRIDGE_M * (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    return shapely.LineString([line[0] - overlap, line[1] + overlap]).buffer(BRIDGE_M / 2.0, cap_style="flat")


def split(contour: FloatArray, direction_rad: float, gap_m: float) -> FloatArray:
    """Return a shape cut in two halves of equal area, moved apart along a direction, and joined by a bridge.

    Parameters
    ----------
    contour : (k, 2) array
        Simple, counter-clockwise [m].
    direction_rad : float
        In which the halves move apart, counter-clockwise from +x [rad]; the cut runs across it.
    gap_m : float
        Free distance between the halves [m].

    Returns
    -------
    (m, 2) array
        Simple, counter-clockwise [m].

    Raises
    ------
    ShapeError
        If the cut leaves more than two pieces.
    """
    along = np.array([np.cos(direction_rad), np.sin(direction_rad)])
    shape = Polygon(contour)
    reach = 2.0 * float(shape.length)
    low, high = -reach, reach
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _beyond(shape, along, middle).area > 0.5 * shape.area else (low, middle)
    halves = []
    for sign in (-1.0, 1.0):
        half = _beyond(shape, sign * along, sign * high)  # a difference to the other half would leave slivers
        if not isinstance(half, Polygon):
            raise ShapeError("the cut leaves more than two pieces; cut in another direction")
        halves.append(_outline(half) + sign * 0.5 * gap_m * along)
    return bridged(halves)


def _beyond(shape: Polygon, along: FloatArray, offset: float) -> BaseGeometry:
    """Return the part of a shape beyond a line across `along`, at an offset from the shape's centroid."""
    reach = 2.0 * float(shape.length)
    across = reach * np.array([-along[1], along[0]])
    edge = shapely.get_coordinates(shape.centroid)[0] + offset * along
    far = edge + 2.0 * reach * along
    return shape.intersection(Polygon([edge - across, far - across, far + across, edge + across]))


def _outline(polygon: Polygon) -> FloatArray:
    outline: FloatArray = np.array(shapely.geometry.polygon.orient(polygon).exterior.coords[:-1])
    return outline
