"""The polygons in a GeoJSON document (RFC 7946); `geographic` says what their coordinates are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from swarm_msgs_py.errors import ShapeError

_REMEDY = "give a Polygon, or a Feature or FeatureCollection that holds one"


def geojson_parts(record: Mapping[str, object], name: str) -> list[list[object]]:
    """Return the rings of every polygon in a GeoJSON object, the outer one first, heights dropped.

    Parameters
    ----------
    record : mapping
        Parsed GeoJSON: Polygon, MultiPolygon, Feature, FeatureCollection or GeometryCollection.
    name : str
        What to call the source in errors.

    Raises
    ------
    ShapeError
        If there is no polygon, or one is no list of rings.
    """
    polygons = list(_polygons(record, name))
    if not polygons:
        raise ShapeError(f"{name}: holds no polygon; {_REMEDY}")
    return [_rings(polygon, name) for polygon in polygons]


def _rings(polygon: object, name: str) -> list[object]:
    if not isinstance(polygon, list) or not polygon:
        raise ShapeError(f"{name}: the polygon is empty; give at least 3 vertices")
    rings: list[object] = []
    for ring in polygon:
        if not isinstance(ring, list):
            raise ShapeError(f"{name}: polygon coordinates must be a list of rings; wrap the ring in one more list")
        rings.append([row[:2] if isinstance(row, list) and len(row) == 3 else row for row in ring])
    return rings


def _polygons(record: object, name: str) -> Iterator[object]:
    """Yield the coordinates of every polygon under a GeoJSON object."""
    if not isinstance(record, Mapping):
        return
    kind = record.get("type")
    if kind == "Polygon":
        yield record.get("coordinates")
    elif kind == "MultiPolygon":
        yield from _list(record.get("coordinates"), name)
    elif kind == "Feature":
        yield from _polygons(record.get("geometry"), name)
    elif kind == "FeatureCollection":
        for feature in _list(record.get("features"), name):
            yield from _polygons(feature, name)
    elif kind == "GeometryCollection":
        for geometry in _list(record.get("geometries"), name):
            yield from _polygons(geometry, name)
    elif not isinstance(kind, str):
        raise ShapeError(f"{name}: neither GeoJSON (no 'type') nor a shape with 'vertices'; {_REMEDY}")


def _list(value: object, name: str) -> list[object]:
    if not isinstance(value, list):
        raise ShapeError(f"{name}: not valid GeoJSON (a list is missing); {_REMEDY}")
    return value
