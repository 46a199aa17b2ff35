"""The frontier of one robot: which samples of its sense sphere are in the shape and in nobody else's coverage."""

from __future__ import annotations

from typing import Self

import numpy as np

from swarm_agent.coverage.sense_sphere import covered_samples
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import BoolArray, FloatArray


class Frontier:
    """Frontier points of one robot, in coordinates relative to it (assumption A2).

    A robot is *close* (closeAR) within 2 r_sc: only then the two balls meet. The same test serves in both directions
    [I22]: a new robot drops those of its own samples that close robots cover, and they drop those that it covers.

    Parameters
    ----------
    directions : (q, 3) array
        Samples of the unit sphere.
    radius : float
        r_sc [m].
    is_open : (q,) bool array
        Which samples are frontier points.
    """

    def __init__(self, directions: FloatArray, radius: float, is_open: BoolArray) -> None:
        self._directions = directions
        self._radius = radius
        self._open = is_open

    @classmethod
    def around(
        cls, position: FloatArray, directions: FloatArray, radius: float, solid: Solid, close: FloatArray
    ) -> Self:
        """Return the frontier of a robot that switches its sensor on (Algorithm 2, step 3).

        Parameters
        ----------
        position : (3,) array
            Its place [m].
        directions, radius
            As for the class.
        solid : Solid
            Shape to cover.
        close : (m, 3) array
            Close robots with their sensors on, relative to it [m].
        """
        is_open = solid.contains(position + radius * directions)
        if is_open.any() and len(close):
            is_open[is_open] = ~covered_samples(directions[is_open], radius, close).any(axis=1)
        return cls(directions, radius, is_open)

    @property
    def size(self) -> int:
        """Number of frontier points."""
        return int(np.count_nonzero(self._open))

    @property
    def samples(self) -> np.ndarray:
        """Numbers of the samples that are frontier points, ascending."""
        return np.flatnonzero(self._open)

    @property
    def points(self) -> FloatArray:
        """Frontier points, relative to the robot, (k, 3) [m]."""
        return self._radius * self._directions[self._open]

    def delete_within(self, offset: FloatArray) -> int:
        """Drop the points that a robot at `offset` (3,) [m] covers; return how many."""
        left = np.flatnonzero(self._open)
        gone = left[covered_samples(self._directions[left], self._radius, offset[None])[:, 0]]
        self._open[gone] = False
        return len(gone)
