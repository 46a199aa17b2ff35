"""A shape from wherever the operator has it: library name, file, or points."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mission_computer.shape.geojson import geojson_ring
from mission_computer.shape.library import library_names, library_points
from mission_computer.shape.validation import validate
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import area_centroid
from swarm_msgs_py.types import FloatArray

FILE_BYTES_MAX = 10_000_000  # a contour of 100 000 vertices; more is a wrong file, not a shape

ShapeSource = str | Path | Sequence[Sequence[float]] | FloatArray


def load_shape(
    source: ShapeSource,
    *,
    scale: float = 1.0,
    rotation: float = 0.0,
    translation: tuple[float, float] = (0.0, 0.0),
) -> FloatArray:
    """Return the contour that `source` describes.

    Parameters
    ----------
    source : str, path or (n, 2) points
        Library name, path of a JSON file (GeoJSON; a list of points; or an object with ``vertices``), JSON text, or the
        points themselves. Coordinates are metres in the world frame, in GeoJSON too.
    scale : float
        Size factor about the center of area, > 0.
    rotation : float
        Turn about the center of area, counter-clockwise [rad].
    translation : (x, y)
        Shift after that [m].

    Returns
    -------
    (k, 2) array
        Simple contour, counter-clockwise, first vertex not repeated.

    Raises
    ------
    ShapeError
        One line that names the source, what is wrong and what to do.
    """
    name, points = _read(source)
    if not (math.isfinite(scale) and scale > 0.0):
        raise ShapeError(f"{name}: scale must be a number > 0, got {scale:g}")
    if not all(math.isfinite(number) for number in (rotation, *translation)):
        raise ShapeError(f"{name}: rotation and translation must be finite, got {rotation:g} and {translation}")
    contour = validate(points, name)
    if scale == 1.0 and rotation == 0.0 and translation == (0.0, 0.0):
        return contour
    center = area_centroid(contour)
    turn = np.array([[math.cos(rotation), math.sin(rotation)], [-math.sin(rotation), math.cos(rotation)]])
    return validate(center + scale * (contour - center) @ turn + translation, name)


def _read(source: ShapeSource) -> tuple[str, FloatArray]:
    """Return what to call the source in errors, and its unchecked (n, 2) points."""
    if isinstance(source, str):
        if source in library_names():
            return f"shape '{source}'", library_points(source)
        if source.lstrip().startswith(("[", "{")):
            return "inline shape", _parse(source, "inline shape")
        if not _looks_like_file(source):
            return source, library_points(source)
    if isinstance(source, str | Path):
        return str(source), _parse(_text_of(Path(source)), str(source))
    return "inline shape", _points(source, "inline shape")


def _looks_like_file(source: str) -> bool:
    return bool(Path(source).suffix) or "/" in source or "\\" in source or Path(source).is_file()


def _text_of(path: Path) -> str:
    try:
        if path.stat().st_size > FILE_BYTES_MAX:
            raise ShapeError(f"{path}: larger than {FILE_BYTES_MAX // 1_000_000} MB; give one contour")
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ShapeError(f"{path}: no such file; give a library name or the path of a JSON file") from None
    except OSError as error:
        raise ShapeError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None
    except UnicodeDecodeError:
        raise ShapeError(f"{path}: not a text file; give GeoJSON or a JSON list of points") from None


def _parse(text: str, name: str) -> FloatArray:
    try:
        record = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        place = f"line {error.lineno}, column {error.colno}" if isinstance(error, json.JSONDecodeError) else "nesting"
        raise ShapeError(f"{name}: not JSON ({place}); give GeoJSON or a JSON list of points") from None
    if isinstance(record, dict) and "vertices" in record:
        return _points(record["vertices"], name)
    if isinstance(record, dict):
        return _points(geojson_ring(record, name), name)
    return _points(record, name)


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
