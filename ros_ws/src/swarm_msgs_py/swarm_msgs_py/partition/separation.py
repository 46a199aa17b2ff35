"""Keeping circles apart and inside: the hard part of a packing, whatever the forces want."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.types import FloatArray

SLACK = 1e-6  # [m]; overlap that counts as none: far below every gap, far above rounding
OVERPUSH = 1.0001  # pairs are pushed a little too far apart, so that the sweeps end
FINAL_SWEEPS = 500  # enough for what is left to part in a tight shape


class Separator:
    """Moves circles into their free regions and overlapping pairs apart, as little as needed.

    Most circles are far from both limits and move little from one call to the next. The separator remembers how far
    each may move before it can break a limit, and looks only at those that have moved farther; results are the same.

    Parameters
    ----------
    domain : Domain
    """

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        count = len(domain.radii)
        self._seen = np.zeros((count, 2))
        self._room = np.full(count, -1.0)  # how far each may go from where it was seen; -1: never seen
        self._pairs_seen = np.zeros((count, 2))
        self._pairs_room = -1.0
        self._upper = np.triu(np.ones((count, count), dtype=bool), 1)

    def apart(self, centers: FloatArray, sweeps: int) -> FloatArray:
        """Return the (n, 2) centers inside their free regions, and apart as far as `sweeps` sweeps of pushing get.

        Pairs may still overlap where room is tight; `is_separated` tells.
        """
        centers = self._inside(centers)
        for _ in range(sweeps):
            first, second, depth = self._overlaps(centers)
            if not len(depth):
                break
            offsets = centers[first] - centers[second]
            distances = np.linalg.norm(offsets, axis=1)
            # Two circles at one point part along x; which way does not matter, that it is always the same does.
            units = np.where(distances[:, None] > SLACK, offsets / np.maximum(distances, SLACK)[:, None], [1.0, 0.0])
            pushes = 0.5 * OVERPUSH * depth[:, None] * units
            np.add.at(centers, first, pushes)
            np.add.at(centers, second, -pushes)
            centers = self._inside(centers)
        return centers

    def is_separated(self, centers: FloatArray) -> bool:
        """Return whether every two of the (n, 2) centers keep their least distance."""
        return not len(self._overlaps(centers)[2])

    def _inside(self, centers: FloatArray) -> FloatArray:
        """Return a copy of the centers, those outside their free region moved to its nearest point."""
        inside = centers.copy()
        offsets = centers - self._seen
        far = np.einsum("nd,nd->n", offsets, offsets) >= np.maximum(self._room, 0.0) ** 2
        if far.any():
            for radius, region in zip(self._domain.classes, self._domain.regions, strict=True):
                rows = np.flatnonzero(far & (self._domain.radii == radius))
                if rows.size:
                    inside[rows], self._room[rows] = region.project(centers[rows])
                    self._seen[rows] = inside[rows]
        return inside

    def _overlaps(
        self, centers: FloatArray
    ) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], np.ndarray[tuple[int], np.dtype[np.int64]], FloatArray]:
        """Return the pairs that are too near (both indices), and by how much each [m]."""
        offsets = centers - self._pairs_seen
        # Two centers that each move less than half the room between them cannot come too near.
        if 4.0 * float(np.einsum("nd,nd->n", offsets, offsets).max()) < max(self._pairs_room, 0.0) ** 2:
            none = np.empty(0, dtype=np.int64)
            return none, none, np.empty(0)
        x, y = centers.T
        dx, dy = x[:, None] - x, y[:, None] - y
        lack = self._domain.least_distances - np.sqrt(dx * dx + dy * dy)
        first, second = np.nonzero((lack > SLACK) & self._upper)
        self._pairs_seen = centers.copy()
        self._pairs_room = -float(np.max(lack, where=self._upper, initial=-np.inf))
        return first, second, lack[first, second]
