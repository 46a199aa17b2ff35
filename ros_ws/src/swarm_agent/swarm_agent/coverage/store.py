"""Frontiers of many robots at once: what the planner and the tests keep, and no single robot has."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from swarm_agent.coverage.sense_sphere import covered_samples
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

Cell = tuple[int, int, int]


class FrontierStore:
    """Frontiers of robots that switch their sensors on one after the other.

    Robots are found by cells of edge 2 r_sc, so that a new one looks into 27 cells, however many there are; a k-d tree
    would have to be built again for each.

    Parameters
    ----------
    directions : (q, 3) array
        Samples of the unit sphere.
    radius : float
        r_sc [m].
    solid : Solid
        Shape to cover.
    """

    def __init__(self, directions: FloatArray, radius: float, solid: Solid) -> None:
        self._directions = directions
        self._radius = radius
        self._solid = solid
        self._cells: defaultdict[Cell, list[int]] = defaultdict(list)
        self._positions = np.empty((0, 3))
        self._open = np.empty((0, len(directions)), dtype=np.bool_)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def positions(self) -> FloatArray:
        """Where the robots are, in the order in which they were enabled, (n, 3) [m]."""
        return self._positions[: self._count]

    @property
    def is_open(self) -> BoolArray:
        """Which samples of which robots are frontier points, (n, q)."""
        return self._open[: self._count]

    def enable(self, position: FloatArray) -> int:
        """Switch on the sensor of a robot at `position` (3,) [m]; return its number."""
        close = self.near(position, 2.0 * self._radius)
        is_open = self._solid.contains(position + self._radius * self._directions)
        if len(close):
            offsets = self._positions[close] - position
            is_open &= ~covered_samples(self._directions, self._radius, offsets).any(axis=1)
            # Seen from there, the newcomer is at the opposite offset.
            self._open[close] &= ~covered_samples(self._directions, self._radius, -offsets).T
        return self._append(position, is_open)

    def give_up(self, robot: int) -> None:
        """Leave what is left of a robot's frontier to the others."""
        self._open[robot] = False

    def near(self, position: FloatArray, reach: float) -> IntArray:
        """Return the numbers of the robots within `reach` [m] of `position`, ascending."""
        size = 2.0 * self._radius
        x, y, z = np.floor(position / size).astype(int).tolist()
        span = range(-int(np.ceil(reach / size)), int(np.ceil(reach / size)) + 1)
        cells = [(x + i, y + j, z + k) for i in span for j in span for k in span]
        found = np.array(
            sorted(robot for cell in cells if cell in self._cells for robot in self._cells[cell]), np.int64
        )
        offsets = self._positions[found] - position
        near: IntArray = found[np.einsum("ij,ij->i", offsets, offsets) <= reach * reach]
        return near

    def points_of(self, robots: IntArray) -> FloatArray:
        """Return the frontier points of `robots`, (k, 3) [m]."""
        row, sample = np.nonzero(self._open[robots])
        points: FloatArray = self._positions[robots][row] + self._radius * self._directions[sample]
        return points

    def _append(self, position: FloatArray, is_open: BoolArray) -> int:
        if self._count == len(self._positions):
            more = max(16, self._count)
            self._positions = np.concatenate([self._positions, np.empty((more, 3))])
            self._open = np.concatenate([self._open, np.zeros((more, self._open.shape[1]), dtype=np.bool_)])
        number = self._count
        self._positions[number] = position
        self._open[number] = is_open
        x, y, z = np.floor(position / (2.0 * self._radius)).astype(int).tolist()
        self._cells[x, y, z].append(number)
        self._count += 1
        return number
