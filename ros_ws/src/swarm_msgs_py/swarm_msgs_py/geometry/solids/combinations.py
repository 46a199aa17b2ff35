"""Solids made of solids: union, intersection, difference, and the same solid elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import BoolArray, FloatArray


class Union:
    """All that is in one of the `parts` at least."""

    def __init__(self, parts: Sequence[Solid]) -> None:
        self._parts = tuple(parts)

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        boxes = np.stack([part.bounds for part in self._parts])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        inside = self._parts[0].contains(points)
        for part in self._parts[1:]:
            left = ~inside
            inside[left] = part.contains(points[left])
        return inside


class Intersection:
    """All that is in every one of the `parts`.

    Raises
    ------
    ShapeError
        If their bounding boxes have nothing in common.
    """

    def __init__(self, parts: Sequence[Solid]) -> None:
        self._parts = tuple(parts)
        lower, upper = self.bounds
        if (lower >= upper).any():
            raise ShapeError("the parts of an intersection have nothing in common")

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        boxes = np.stack([part.bounds for part in self._parts])
        return np.stack([boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        inside = self._parts[0].contains(points)
        for part in self._parts[1:]:
            inside[inside] = part.contains(points[inside])
        return inside


class Difference:
    """All of `whole` that is in none of the `holes`; a surface that they share belongs to the hole."""

    def __init__(self, whole: Solid, holes: Sequence[Solid]) -> None:
        self._whole = whole
        self._holes = tuple(holes)

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]."""
        return self._whole.bounds

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        inside = self._whole.contains(points)
        for hole in self._holes:
            inside[inside] = ~hole.contains(points[inside])
        return inside


class Moved:
    """A solid turned about the origin, then shifted.

    Parameters
    ----------
    solid : Solid
    offset : (3,) array
        Shift [m].
    turn : (4,) array
        Unit quaternion (x, y, z, w).
    """

    def __init__(self, solid: Solid, offset: FloatArray, turn: FloatArray) -> None:
        self._solid = solid
        self._offset = np.asarray(offset, dtype=np.float64)
        self._matrix = Rotation.from_quat(turn).as_matrix()

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner, (2, 3) [m]; where the solid is turned, not the tightest."""
        picks = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        corners = self._solid.bounds[picks, np.arange(3)] @ self._matrix.T + self._offset
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside, (n,)."""
        return self._solid.contains((points - self._offset) @ self._matrix)
