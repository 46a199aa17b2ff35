"""What the swarm is to look like: shapes from names, files and points, checked before anything starts."""

from mission_computer.shape.library import arena_names, library_names
from mission_computer.shape.source import load_shape
from mission_computer.shape.validation import check_inside

__all__ = ["arena_names", "check_inside", "library_names", "load_shape"]
