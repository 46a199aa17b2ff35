"""Arenas: bounds and obstacles, from a named map or a file."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mission_computer.shape.library import arena_names, arena_text, suggestion
from mission_computer.shape.validation import validate
from swarm_msgs_py.config import Config, load_config, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle(Config):
    """A wall that neither robots nor radio links cross."""

    name: str = setting(help="what to call it in messages")
    vertices_m: tuple[tuple[float, float], ...] = setting(help="outline [x, y], once around", unit="m")

    def polygon(self) -> FloatArray:
        """Return the outline, (k, 2) counter-clockwise [m].

        Raises
        ------
        ShapeError
            If it is not a simple polygon.
        """
        return validate(np.array(self.vertices_m, dtype=np.float64).reshape(-1, 2), f"obstacle '{self.name}'")


@dataclass(frozen=True, slots=True, kw_only=True)
class Arena(Config):
    """A place to form shapes in."""

    name: str = setting(help="name of the arena")
    bounds_m: tuple[float, float, float, float] = setting(help="least x, least y, greatest x, greatest y", unit="m")
    obstacles: tuple[Obstacle, ...] = setting((), "walls")


def load_arena(source: str | Path) -> Arena:
    """Return a named arena of the package, or one from a JSON file.

    Raises
    ------
    ConfigError
        If there is no such arena, or its file is not as declared; one line with file, key and remedy.
    """
    name = str(source)
    if name in arena_names():
        text = arena_text(name)
    elif isinstance(source, str) and not Path(source).suffix and "/" not in source:
        raise ConfigError(
            f"arena '{name}' is neither a map of the package nor a file; {suggestion(name, arena_names())}"
        )
    else:
        try:
            text = Path(source).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"{name}: cannot be read ({type(error).__name__}); give a map name or a file") from None
    try:
        return load_config(Arena, json.loads(text), name)
    except json.JSONDecodeError as error:
        raise ConfigError(f"{name}: not JSON (line {error.lineno}, column {error.colno}); correct the file") from None
