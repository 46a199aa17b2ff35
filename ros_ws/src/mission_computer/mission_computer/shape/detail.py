"""How much detail a contour may have: all that a plan tells of it must fit into a radio packet."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.errors import ShapeError

VERTICES_MAX = 128  # contour bytes in the plan frame: 4 per vertex, half a KiB at this number
VERTICES_PER_CUT = 4  # that a slit to a hole, or a bridge to a part, adds to the contour
THINNING = 1e-4  # of the side of a square of the same area: so far a vertex may be off the contour after it
SPECK = 1e-3  # share of the largest part's area; smaller parts and holes of drawings are dirt
AREA_LOSS_MAX = 0.05  # share of the area by which fewer vertices may change it


def simplified(region: Polygon | MultiPolygon, name: str, vertices_max: int = VERTICES_MAX) -> Polygon | MultiPolygon:
    """Return a region whose contour has at most so many vertices, and the same area and center to first order.

    Raises
    ------
    ShapeError
        If so few vertices cannot tell this shape (a coast line, a scan with noise, a long text).
    """
    if _vertices(region) <= vertices_max:
        return region
    whole, side = region, float(np.sqrt(region.area))
    region = region.simplify(THINNING * side)  # cheap, and hardly seen
    low, high = 0.0, side
    for _ in range(40):  # bisection for the smallest tolerance that gets below the limit
        middle = 0.5 * (low + high)
        if _vertices(_simpler(region, middle)) > vertices_max:
            low = middle
        else:
            high = middle
    fewer = _simpler(region, high)
    if (
        fewer.is_empty
        or not fewer.is_valid
        or _vertices(fewer) > vertices_max
        or abs(fewer.area / whole.area - 1.0) > AREA_LOSS_MAX
    ):
        count = _vertices(whole)
        raise ShapeError(f"{name}: {count} vertices are too much detail; smooth it to {vertices_max} vertices")
    return fewer


def without_specks(region: BaseGeometry, share: float = SPECK) -> Polygon | MultiPolygon:
    """Return a region without parts and holes that are smaller than this share of its largest part."""
    parts = [part for part in shapely.get_parts(region) if isinstance(part, Polygon)]
    least = share * max(part.area for part in parts)
    kept = [
        Polygon(part.exterior, [hole for hole in part.interiors if Polygon(hole).area >= least])
        for part in parts
        if part.area >= least
    ]
    return kept[0] if len(kept) == 1 else MultiPolygon(kept)


def _simpler(region: Polygon | MultiPolygon, tolerance: float) -> Polygon | MultiPolygon:
    """Return a region without corners whose triangles are smaller than the square of a tolerance [m].

    That (Visvalingam and Whyatt's rule) changes the area less than rules that look at distances, and looking at all
    parts together keeps them apart.
    """
    parts = shapely.coverage_simplify(shapely.get_parts(region), tolerance).tolist()
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def _vertices(region: BaseGeometry) -> int:
    """Return how many vertices the one contour around a region has."""
    parts = shapely.get_parts(region)
    rings = sum(1 + len(part.interiors) for part in parts)
    return len(shapely.get_coordinates(region)) - rings + VERTICES_PER_CUT * (rings - 1)
