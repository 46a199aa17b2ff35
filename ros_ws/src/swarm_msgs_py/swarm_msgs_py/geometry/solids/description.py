"""Solids as plain data: what a scenario file says, what a person writes, what travels over the radio."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_msgs_py.config import Config, at, load_config, setting
from swarm_msgs_py.errors import ConfigError, FrameError, ShapeError
from swarm_msgs_py.geometry.solids.combinations import Difference, Intersection, Moved, Union
from swarm_msgs_py.geometry.solids.mesh import TriangleMesh, load_mesh
from swarm_msgs_py.geometry.solids.primitives import Ball, Box, Prism
from swarm_msgs_py.geometry.solids.solid import Solid

DEPTH_MAX = 16  # solids within solids
SIZE_MAX = 1 << 22  # of a description on the air once unpacked [byte]; more is no shape but an attack on the memory
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class BallSpec(Config):
    """A ball."""

    center_m: Triple = setting((0.0, 0.0, 0.0), "center of the ball", unit="m")
    radius_m: float = setting(help="radius of the ball", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxSpec(Config):
    """A box with edges along the axes."""

    center_m: Triple = setting((0.0, 0.0, 0.0), "center of the box", unit="m")
    size_m: Triple = setting(help="lengths of its edges along x, y, z", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PrismSpec(Config):
    """A polygon, extruded upward."""

    corners_m: tuple[tuple[float, float], ...] = setting(help="corners of the polygon, seen from above", unit="m")
    bottom_m: float = setting(0.0, "height at which it begins", unit="m")
    top_m: float = setting(help="height at which it ends", unit="m")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshFileSpec(Config):
    """A closed mesh in a file."""

    file: str = setting(help="STL or OBJ file, relative to the scenario")
    scale: float = setting(1.0, "meters per unit of the file", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshSpec(Config):
    """A closed mesh in full."""

    vertices_m: tuple[Triple, ...] = setting(help="corners of the triangles", unit="m")
    faces: tuple[tuple[int, int, int], ...] = setting(help="three rows of vertices_m per triangle", minimum=0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveSpec(Config):
    """Where a moved solid goes."""

    offset_m: Triple = setting((0.0, 0.0, 0.0), "shift", unit="m")
    turn_xyzw: tuple[float, float, float, float] = setting((0.0, 0.0, 0.0, 1.0), "quaternion of a turn before it")


def solid_from(data: object, where: str = "shape") -> Solid:
    """Return the solid that plain data describes.

    Parameters
    ----------
    data : object
        A mapping with ``kind`` (ball, box, prism, mesh; union, intersection with ``of``; difference with ``whole`` and
        ``holes``; moved with ``of``) and what that kind needs; in full, without files (see `inlined`).
    where : str
        Begins every error.

    Raises
    ------
    ShapeError
        If the data describes no solid: one line with the place, the trouble and the remedy.
    """
    return _solid_from(data, where, 0)


def inlined(data: object, folder: Path, where: str = "shape") -> dict[str, Any]:
    """Return the same description with every mesh file replaced by what it holds, so that it can travel.

    Parameters
    ----------
    data : object
        As for `solid_from`, where ``mesh`` may have ``file`` and ``scale`` instead of ``vertices_m`` and ``faces``.
    folder : Path
        What file names are relative to.
    where : str
        Begins every error.

    Raises
    ------
    ShapeError
        If a file cannot be read, or the data describes no solid.
    """
    plain = _inlined(data, folder, where, 0)
    solid_from(plain, where)
    return plain


def packed_description(data: Mapping[str, Any]) -> bytes:
    """Return a description in bytes, for the radio; equal descriptions give equal bytes."""
    return zlib.compress(json.dumps(data, sort_keys=True, separators=(",", ":")).encode(), 9)


def unpacked_description(data: bytes) -> dict[str, Any]:
    """Return the description that came over the radio.

    Raises
    ------
    FrameError
        If the bytes are none.
    """
    reader = zlib.decompressobj()
    try:
        text = reader.decompress(data, SIZE_MAX)
        plain = json.loads(text) if reader.eof and not reader.unused_data else None
    except (zlib.error, ValueError, RecursionError):
        plain = None
    if not isinstance(plain, dict):
        raise FrameError(f"{len(data)} bytes describe no solid")
    return plain


def _solid_from(data: object, where: str, depth: int) -> Solid:
    kind, rest = _taken_apart(data, where, depth)
    try:
        return _KINDS[kind](rest, where, depth + 1)
    except ConfigError as error:
        raise ShapeError(str(error)) from None
    except ShapeError as error:
        raise error if str(error).startswith(where) else ShapeError(f"{where}: {error}") from None


def _inlined(data: object, folder: Path, where: str, depth: int) -> dict[str, Any]:
    kind, rest = _taken_apart(data, where, depth)
    if kind == "mesh" and "file" in rest:
        try:
            spec = load_config(MeshFileSpec, rest, where)
            vertices, faces = load_mesh(folder / spec.file, spec.scale)
        except (ConfigError, ShapeError) as error:
            raise ShapeError(str(error) if str(error).startswith(where) else f"{where}: {error}") from None
        return {"kind": kind, "vertices_m": vertices.tolist(), "faces": faces.tolist()}
    plain: dict[str, Any] = {"kind": kind}
    for key, value in rest.items():
        if isinstance(value, Mapping):
            plain[key] = _inlined(value, folder, at(where, key), depth + 1)
        elif key in {"of", "holes"} and isinstance(value, list | tuple):
            plain[key] = [_inlined(part, folder, at(where, f"{key}[{i}]"), depth + 1) for i, part in enumerate(value)]
        else:
            plain[key] = value
    return plain


def _taken_apart(data: object, where: str, depth: int) -> tuple[str, dict[str, Any]]:
    """Return the kind of a solid and everything else that is said of it."""
    if depth > DEPTH_MAX:
        raise ShapeError(f"{where}: more than {DEPTH_MAX} solids within solids")
    if not isinstance(data, Mapping):
        raise ShapeError(f"{where}: expected keys and values with 'kind', got {type(data).__name__}")
    kind = data.get("kind")
    if kind not in _KINDS:
        raise ShapeError(f"{at(where, 'kind')}: '{kind}' is no solid; choose from: {', '.join(sorted(_KINDS))}")
    return str(kind), {str(key): value for key, value in data.items() if key != "kind"}


def _ball(rest: dict[str, Any], where: str, _: int) -> Solid:
    spec = load_config(BallSpec, rest, where)
    return Ball(np.array(spec.center_m), spec.radius_m)


def _box(rest: dict[str, Any], where: str, _: int) -> Solid:
    spec = load_config(BoxSpec, rest, where)
    return Box(np.array(spec.center_m), np.array(spec.size_m))


def _prism(rest: dict[str, Any], where: str, _: int) -> Solid:
    spec = load_config(PrismSpec, rest, where)
    return Prism(np.array(spec.corners_m).reshape(-1, 2), spec.bottom_m, spec.top_m)


def _mesh(rest: dict[str, Any], where: str, _: int) -> Solid:
    if "file" in rest:
        raise ShapeError(f"{where}: the mesh is still in a file")
    spec = load_config(MeshSpec, rest, where)
    return TriangleMesh(np.array(spec.vertices_m).reshape(-1, 3), np.array(spec.faces, dtype=np.int64).reshape(-1, 3))


def _union(rest: dict[str, Any], where: str, depth: int) -> Solid:
    return Union(_parts(rest, "of", where, depth, {"of"}))


def _intersection(rest: dict[str, Any], where: str, depth: int) -> Solid:
    return Intersection(_parts(rest, "of", where, depth, {"of"}))


def _difference(rest: dict[str, Any], where: str, depth: int) -> Solid:
    holes = _parts(rest, "holes", where, depth, {"whole", "holes"})
    return Difference(_solid_from(rest.get("whole"), at(where, "whole"), depth), holes)


def _moved(rest: dict[str, Any], where: str, depth: int) -> Solid:
    spec = load_config(MoveSpec, {key: value for key, value in rest.items() if key != "of"}, where)
    turn = np.array(spec.turn_xyzw)
    if not np.linalg.norm(turn) > 0.0:
        raise ShapeError(f"{at(where, 'turn_xyzw')}: a quaternion of length 0 is no turn")
    return Moved(_solid_from(rest.get("of"), at(where, "of"), depth), np.array(spec.offset_m), turn)


def _parts(rest: dict[str, Any], key: str, where: str, depth: int, allowed: set[str]) -> list[Solid]:
    unknown = sorted(set(rest) - allowed)
    if unknown:
        raise ShapeError(f"{at(where, unknown[0])}: unknown key; choose from: kind, {', '.join(sorted(allowed))}")
    parts = rest.get(key)
    if not isinstance(parts, list | tuple) or not parts:
        raise ShapeError(f"{at(where, key)}: expected a list of at least one solid")
    return [_solid_from(part, at(where, f"{key}[{index}]"), depth) for index, part in enumerate(parts)]


_KINDS: Mapping[str, Callable[[dict[str, Any], str, int], Solid]] = {
    "ball": _ball,
    "box": _box,
    "prism": _prism,
    "mesh": _mesh,
    "union": _union,
    "intersection": _intersection,
    "difference": _difference,
    "moved": _moved,
}
