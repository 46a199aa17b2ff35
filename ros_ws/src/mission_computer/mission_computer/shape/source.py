"""A shape from wherever the operator has it: library name, file, drawing, picture, text, or points."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.validation import explain_validity

from mission_computer.shape.detail import SPECK, simplified, without_specks
from mission_computer.shape.filling import polygonal
from mission_computer.shape.geographic import CoordinateUnit, projected, unit_of
from mission_computer.shape.geojson import geojson_parts
from mission_computer.shape.library import library_names, library_points
from mission_computer.shape.placement import Placement
from mission_computer.shape.validation import checked_ring, validate
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.bridges import one_contour
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.types import FloatArray

FILE_BYTES_MAX = 10_000_000  # a contour of 100 000 vertices; more is a wrong file, not a shape
TEXT_PREFIX = "text:"
DRAWING_SUFFIXES = (".svg",)
PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".webp", ".tif", ".tiff", ".pbm", ".pgm")

ShapeSource = str | Path | Sequence[Sequence[float]] | FloatArray


def load_shape(
    source: ShapeSource,
    *,
    scale: float = 1.0,
    rotation: float = 0.0,
    translation: tuple[float, float] = (0.0, 0.0),
    unit: CoordinateUnit | None = None,
) -> FloatArray:
    """Return the contour that `source` describes; as `placed_shape`, with the placement in short."""
    return placed_shape(source, Placement(scale=scale, rotation=rotation, translation=translation), unit=unit)


def placed_shape(
    source: ShapeSource, placement: Placement, font: str | None = None, unit: CoordinateUnit | None = None
) -> FloatArray:
    """Return the contour that `source` describes, placed.

    Parameters
    ----------
    source : str, path or (n, 2) points
        Library name; path of a JSON file (GeoJSON; a list of points; or an object with ``vertices``), of an SVG drawing
        or of a picture; ``text:`` with a text; JSON text; or the points themselves. Coordinates are meters in the world
        frame, those of GeoJSON meters or degrees of longitude and latitude (`geographic`). Drawings, pictures and texts
        have no unit of length: one unit, one pixel or the size of the font is a meter before they are placed.
    placement : Placement
    font : str or None
        For a text: family with style, or a font file; None for the one that is always there.
    unit : CoordinateUnit or None
        Of the coordinates of GeoJSON; None: what only makes sense.

    Returns
    -------
    (k, 2) array
        Simple contour, counter-clockwise, first vertex not repeated. Parts are joined by bridges and holes are opened
        by slits, both too narrow to matter (`swarm_msgs_py.geometry.bridges`).

    Raises
    ------
    ShapeError
        One line that names the source, what is wrong and what to do.
    """
    name, region = _read(source, font, unit)
    placement.check(name)
    if isinstance(region, np.ndarray):
        return _placed_ring(region, placement, name)
    whole = without_specks(region, SPECK if is_drawing(source) else 0.0)
    return _placed_region(whole, placement, name)


def is_drawing(source: ShapeSource) -> bool:
    """Return whether a source has no unit of length: a drawing, a picture, a text."""
    if isinstance(source, str) and source.startswith(TEXT_PREFIX):
        return True
    is_path = isinstance(source, str | Path) and source not in library_names()
    return is_path and Path(str(source)).suffix.lower() in DRAWING_SUFFIXES + PICTURE_SUFFIXES


def _placed_ring(points: FloatArray, placement: Placement, name: str) -> FloatArray:
    contour = validate(points, name)
    if placement.is_none:
        return contour
    extent = contour.max(axis=0) - contour.min(axis=0)
    factor = placement.factor((float(extent[0]), float(extent[1])), signed_area(contour))
    return validate(placement.moved(contour, area_centroid(contour), factor), name)


def _placed_region(whole: Polygon | MultiPolygon, placement: Placement, name: str) -> FloatArray:
    fewer = simplified(whole, name)
    center, growth = np.array(fewer.centroid.coords[0]), float(np.sqrt(whole.area / fewer.area))
    fewer = shapely.transform(fewer, lambda points: center + growth * (points - center))
    try:
        return validate(one_contour(placement.of_region(fewer)), name)
    except ShapeError as error:
        text = str(error)
        raise ShapeError(text if text.startswith(name) else f"{name}: {text}") from None


def _read(source: ShapeSource, font: str | None, unit: CoordinateUnit | None) -> tuple[str, FloatArray | BaseGeometry]:
    """Return what to call the source in errors, and its unchecked (n, 2) points, or its region if there are several."""
    if isinstance(source, str):
        if source in library_names():
            return f"shape '{source}'", library_points(source)
        if source.startswith(TEXT_PREFIX):
            text = source.removeprefix(TEXT_PREFIX)
            region: BaseGeometry = _reader("lettering").text_region(text, font)
            return f"text '{text}'", region
        if source.lstrip().startswith(("[", "{")):
            return "inline shape", _parse(source, "inline shape", unit)
        if not _looks_like_file(source):
            return source, library_points(source)
    if isinstance(source, str | Path):
        return str(source), _read_file(Path(source), unit)
    return "inline shape", _points(source, "inline shape")


def _reader(module: str) -> ModuleType:
    """Return a module that reads drawings; only who has one waits for its libraries."""
    return import_module(f"mission_computer.shape.{module}")


def _looks_like_file(source: str) -> bool:
    return bool(Path(source).suffix) or "/" in source or "\\" in source or Path(source).is_file()


def _read_file(path: Path, unit: CoordinateUnit | None) -> FloatArray | BaseGeometry:
    suffix = path.suffix.lower()
    _check_size(path)
    if suffix in PICTURE_SUFFIXES:
        return _reader("bitmap").bitmap_region(path)
    if suffix in DRAWING_SUFFIXES:
        return _reader("svg").svg_region(_text_of(path), str(path))
    return _parse(_text_of(path), str(path), unit)


def _check_size(path: Path) -> None:
    try:
        if path.stat().st_size > FILE_BYTES_MAX:
            raise ShapeError(f"{path}: larger than {FILE_BYTES_MAX // 1_000_000} MB; give one contour")
    except FileNotFoundError:
        raise ShapeError(f"{path}: no such file; give a library name or the path of a file") from None
    except OSError as error:
        raise ShapeError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None


def _text_of(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise ShapeError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None
    except UnicodeDecodeError:
        raise ShapeError(f"{path}: not a text file; give GeoJSON, SVG, a picture or a JSON list of points") from None


def _parse(text: str, name: str, unit: CoordinateUnit | None) -> FloatArray | BaseGeometry:
    try:
        record = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        place = f"line {error.lineno}, column {error.colno}" if isinstance(error, json.JSONDecodeError) else "nesting"
        raise ShapeError(f"{name}: not JSON ({place}); give GeoJSON or a JSON list of points") from None
    if isinstance(record, dict) and "vertices" in record:
        return _points(record["vertices"], name)
    if isinstance(record, dict):
        return _mapped(record, name, unit)
    return _points(record, name)


def _mapped(record: Mapping[str, object], name: str, unit: CoordinateUnit | None) -> FloatArray | BaseGeometry:
    """Return what the polygons of a GeoJSON document cover together [m]: neighbors are one.

    Raises
    ------
    ShapeError
        If a ring is no contour, holes cross the outline, or the unit is not clear.
    """
    parts = [[_points(ring, name) for ring in rings] for rings in geojson_parts(record, name)]
    rings = [ring for part in parts for ring in part if len(ring)]
    if rings and unit_of(rings, record, unit, name) is CoordinateUnit.DEGREES:
        flat = iter(projected([ring for part in parts for ring in part]))
        parts = [[next(flat) for _ in part] for part in parts]
    elif len(parts) == 1 and len(parts[0]) == 1:
        return parts[0][0]
    polygons = [_polygon(part, name) for part in parts]
    return polygons[0] if len(polygons) == 1 else polygonal(shapely.union_all(polygons))


def _polygon(rings: Sequence[FloatArray], name: str) -> Polygon:
    outer, *holes = (checked_ring(ring, name, reach=math.inf) for ring in rings)
    polygon = Polygon(outer, holes)
    if not polygon.is_valid:
        raise ShapeError(f"{name}: {explain_validity(polygon)}; holes must lie inside of their part")
    return polygon


def _points(rows: object, name: str) -> FloatArray:
    """Return rows of two numbers as an array; positions in GeoJSON may carry a height, which is dropped there."""
    if isinstance(rows, np.ndarray):
        rows = rows.tolist()
    if not isinstance(rows, Sequence) or isinstance(rows, str | bytes):
        raise ShapeError(f"{name}: expected a list of [x, y] points; give GeoJSON or a JSON list of points")
    for index, row in enumerate(rows):
        fits = isinstance(row, Sequence) and not isinstance(row, str) and len(row) == 2
        if not fits or not all(isinstance(number, int | float) and not isinstance(number, bool) for number in row):
            raise ShapeError(f"{name}: vertex {index + 1} is {_short(row)}; every vertex must be two numbers [x, y]")
    try:
        return np.array(rows, dtype=np.float64).reshape(-1, 2)
    except OverflowError:
        raise ShapeError(f"{name}: a coordinate is too large; give metres in the arena") from None


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
