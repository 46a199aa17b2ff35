"""Coordinates of maps, in meters: GeoJSON tells degrees by its standard, and people write meters into it.

What a file means is found out where only one reading makes sense, and asked for where two do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum

import numpy as np

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray

EARTH_RADIUS = 6_371_008.8  # [m]; mean radius of WGS 84
LEAST_METERS = 0.1  # [m]; whatever is smaller than this has no room for a robot, so it is in degrees
_GEOGRAPHIC = ("CRS84", "EPSG::4326", "EPSG:4326")
_LIMITS = (180.0, 90.0)  # [deg]


class CoordinateUnit(Enum):
    """What the coordinates of a map are."""

    METERS = "m"
    DEGREES = "deg"


def unit_of(
    rings: Sequence[FloatArray], record: Mapping[str, object], told: CoordinateUnit | None, name: str
) -> CoordinateUnit:
    """Return what the coordinates of a GeoJSON document are.

    Parameters
    ----------
    rings : sequence of (k, 2) array
        All of the document.
    record : mapping
        The document. Its member ``crs`` (GeoJSON 2008; many programs still write it) decides if it names a system.
    told : CoordinateUnit or None
        What the operator says.
    name : str
        What to call the source in errors.

    Raises
    ------
    ShapeError
        If both readings make sense, or what the operator says makes none.
    """
    points = np.vstack(rings)
    in_range = bool((np.abs(points) <= _LIMITS).all())
    if told is CoordinateUnit.DEGREES and not in_range:
        raise ShapeError(f"{name}: coordinates beyond 180 and 90 are no degrees; give shape.unit=m if they are meters")
    system = _system(record)
    if told is not None or not in_range:
        return told or CoordinateUnit.METERS
    if system:
        is_geographic = any(system.upper().endswith(known) for known in _GEOGRAPHIC)
        return CoordinateUnit.DEGREES if is_geographic else CoordinateUnit.METERS
    if np.ptp(points, axis=0).max() < LEAST_METERS:
        return CoordinateUnit.DEGREES
    raise ShapeError(f"{name}: the coordinates may be degrees or meters; give shape.unit=deg or shape.unit=m")


def projected(rings: Sequence[FloatArray]) -> list[FloatArray]:
    """Return rings of longitude and latitude [deg] in meters, x to the east and y to the north.

    The projection is the local equirectangular one, x = R cos(lat_0) (lon - lon_0) and y = R (lat - lat_0), about the
    middle of the box around all rings, which becomes (0, 0). Lengths on the ground are true to 1/100 within some 10 km
    and 60 degrees of latitude. Parts to both sides of the antimeridian stay side by side.
    """
    points = np.vstack(rings)
    is_around = np.ptp(points[:, 0]) > _LIMITS[0]
    turned = [ring + np.column_stack([360.0 * ((ring[:, 0] < 0.0) & is_around), np.zeros(len(ring))]) for ring in rings]
    points = np.vstack(turned)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    shrink = np.array([np.cos(np.radians(middle[1])), 1.0])
    return [EARTH_RADIUS * np.radians(ring - middle) * shrink for ring in turned]


def _system(record: Mapping[str, object]) -> str:
    """Return the name of the coordinate system that a document names, or nothing."""
    crs = record.get("crs")
    properties = crs.get("properties") if isinstance(crs, Mapping) else None
    found = properties.get("name") if isinstance(properties, Mapping) else None
    return found if isinstance(found, str) else ""
