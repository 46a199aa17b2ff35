"""Ready-made solids, and the reading of what a scenario says of its shape."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from bringup.coverage.scenario import SolidSpec
from mission_computer.shape.library import suggestion
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.geometry.solids.description import inlined

EDGE_M = 200.0 / 3.0  # of the paper's beams
MESHES = (".stl", ".obj")

_BEAM = {"kind": "box", "size_m": [300.0, EDGE_M, EDGE_M]}
SOLIDS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "ball": {"kind": "ball", "radius_m": 100.0},
        "beam": _BEAM,
        "cross": {"kind": "union", "of": [_BEAM, {"kind": "box", "size_m": [EDGE_M, EDGE_M, 200.0]}]},
        "l": {
            "kind": "union",
            "of": [
                _BEAM,
                {"kind": "box", "center_m": [-150.0 + EDGE_M / 2, 0.0, 100.0], "size_m": [EDGE_M, EDGE_M, 200.0]},
            ],
        },
        "t": {
            "kind": "union",
            "of": [_BEAM, {"kind": "box", "center_m": [0.0, 0.0, -100.0], "size_m": [EDGE_M, EDGE_M, 200.0]}],
        },
        "shell": {
            "kind": "difference",
            "whole": {"kind": "ball", "radius_m": 130.0},
            "holes": [{"kind": "ball", "radius_m": 80.0}],
        },
        "slab": {
            "kind": "prism",
            "corners_m": [[-100.0, -80.0], [100.0, -80.0], [60.0, 80.0], [-60.0, 80.0]],
            "bottom_m": -25.0,
            "top_m": 25.0,
        },
    }
)
"""Descriptions by name (`swarm_msgs_py.geometry.solids.description`)."""


def described(spec: SolidSpec) -> dict[str, Any]:
    """Return the description of a shape, meshes written out.

    Raises
    ------
    ConfigError, ShapeError
        If there is no such solid or file, or it cannot be used.
    """
    data, folder = _source(spec)
    if any(spec.offset_m):
        data = {"kind": "moved", "of": data, "offset_m": list(spec.offset_m)}
    return inlined(data, folder, "solid")


def _source(spec: SolidSpec) -> tuple[dict[str, Any], Path]:
    """Return a description, and the folder that files in it are relative to."""
    here = Path.cwd()
    if spec.solid is not None:
        return dict(spec.solid), here
    if spec.file is None:
        assert spec.name is not None  # SolidSpec sees to it
        if spec.name not in SOLIDS:
            raise ConfigError(f"there is no solid '{spec.name}'; {suggestion(spec.name, tuple(SOLIDS))}")
        return dict(SOLIDS[spec.name]), here
    path = Path(spec.file)
    if path.suffix.lower() in MESHES:
        return {"kind": "mesh", "file": str(path.absolute()), "scale": spec.scale}, here
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ConfigError(f"{path}: no description of a solid ({error}); give an STL, OBJ or JSON file") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: a solid is described by keys and values, such as kind: ball")
    return data, path.parent
