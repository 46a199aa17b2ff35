"""What the swarm is to look like: shapes from names, files and points, checked before anything starts."""

from mission_computer.shape.geographic import CoordinateUnit
from mission_computer.shape.library import arena_names, library_names
from mission_computer.shape.placement import Placement
from mission_computer.shape.room import with_room
from mission_computer.shape.source import TEXT_PREFIX, is_drawing, load_shape, placed_shape
from mission_computer.shape.validation import check_inside

__all__ = [
    "CoordinateUnit",
    "Placement",
    "TEXT_PREFIX",
    "arena_names",
    "check_inside",
    "is_drawing",
    "library_names",
    "load_shape",
    "placed_shape",
    "with_room",
]
