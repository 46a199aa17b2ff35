"""Named shapes and arenas that come with the package."""

from __future__ import annotations

import difflib
import json
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable

import numpy as np

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray


def library_names() -> tuple[str, ...]:
    """Return the names of all library shapes, in alphabetical order."""
    return _names("library")


def arena_names() -> tuple[str, ...]:
    """Return the names of all arenas of the package, in alphabetical order."""
    return _names("maps")


def library_points(name: str) -> FloatArray:
    """Return the vertices of a library shape, (k, 2) [m].

    Raises
    ------
    ShapeError
        If there is no such shape; suggests the nearest name.
    """
    if name not in library_names():
        raise ShapeError(f"shape '{name}' is neither a library shape nor a file; {suggestion(name, library_names())}")
    record = json.loads((_folder("library") / f"{name}.json").read_text(encoding="utf-8"))
    return np.array(record["vertices"], dtype=np.float64)


def arena_text(name: str) -> str:
    """Return the text of the file of a named arena."""
    return (_folder("maps") / f"{name}.json").read_text(encoding="utf-8")


def suggestion(word: str, known: tuple[str, ...]) -> str:
    """Return the remedy for an unknown name: the nearest known one, or all of them."""
    near = difflib.get_close_matches(word, known, n=1)
    return f"did you mean '{near[0]}'?" if near else f"choose from: {', '.join(known)}"


def _folder(name: str) -> Traversable:
    return resources.files("mission_computer") / "shape" / name


@cache
def _names(kind: str) -> tuple[str, ...]:
    folder = _folder(kind)
    return tuple(sorted(entry.name.removesuffix(".json") for entry in folder.iterdir() if entry.name.endswith(".json")))
