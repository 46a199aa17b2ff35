"""Corners of the forbidden space and which of them see each other (thesis section 3.4.2, Algorithm 3).

Only convex corners are nodes, and only tangents are edges: a shortest path turns at a corner around the obstacle, so
it never arrives on a line that cuts the obstacle there. This "reduced" visibility graph has the same shortest paths
as the full one and, with convex obstacles, four edges per pair of them.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from swarm_agent.planning.configuration_space import ConfigurationSpace
from swarm_msgs_py.types import FloatArray, IntArray

TANGENT = 1e-7  # slack of the tangent test [m^2]: accepting a few lines too many is harmless, they are still walked


class VisibilityGraph:
    """Nodes and tangent edges of a configuration space.

    Attributes
    ----------
    nodes : (v, 2) array
        Convex corners of the forbidden space [m].
    """

    def __init__(self, space: ConfigurationSpace) -> None:
        self._walls = space.walls
        corners = [_convex_corners(ring) for ring in space.rings]
        self.nodes, before, after = (
            np.concatenate([*(corner[k] for corner in corners), np.empty((0, 2))]) for k in range(3)
        )
        # Turned by -90 degrees, so that the product with a vector d is cross(direction, d).
        self._before, self._after = (np.ascontiguousarray(np.stack((-e[:, 1], e[:, 0]))) for e in (before, after))

    def tangent_nodes(self, point: FloatArray) -> IntArray:
        """Return the nodes at which a line from `point` touches the obstacle there and does not cut it.

        Parameters
        ----------
        point : (2,) array
            Free position [m].

        Returns
        -------
        (k,) int array
            Row numbers of `nodes`, ascending. Whether the line is free is another question.
        """
        x, y = (self.nodes - point).T
        side = (self._before[0] * x + self._before[1] * y) * (self._after[0] * x + self._after[1] * y)
        # Both ring edges point along the ring; around a corner with a tangent, one climbs and the other returns.
        return np.flatnonzero(side <= TANGENT)

    def visible_nodes(self, point: FloatArray) -> IntArray:
        """Return the nodes to which a free `point` has a tangent that crosses no wall, ascending."""
        tangent = self.tangent_nodes(point)
        return tangent[self._walls.clear_from(point, self.nodes[tangent])]

    def edges(self) -> csr_array:
        """Return the symmetric sparse matrix of the lengths of all edges, (v, v) [m]."""
        count = len(self.nodes)
        touches = np.zeros((count, count), dtype=np.bool_)
        for node, point in enumerate(self.nodes):
            touches[node, self.tangent_nodes(point)] = True
        # A useful edge is a tangent at both ends; only one direction needs the test against the walls.
        candidates = np.triu(touches & touches.T, k=1)
        rows, columns = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
        for node, point in enumerate(self.nodes):
            ends = np.flatnonzero(candidates[node])
            seen = ends[self._walls.clear_from(point, self.nodes[ends])]
            rows.append(np.full(len(seen), node))
            columns.append(seen)
        one, two = np.concatenate(rows), np.concatenate(columns)
        lengths = np.linalg.norm(self.nodes[one] - self.nodes[two], axis=1)
        both = (np.concatenate((one, two)), np.concatenate((two, one)))
        return csr_array((np.concatenate((lengths, lengths)), both), shape=(count, count))


def _convex_corners(ring: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the convex corners of a ring, and the unit directions of the edges to and from each."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    convex = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > 0.0
    before, after = before[convex], after[convex]
    return (
        ring[convex],
        before / np.linalg.norm(before, axis=1, keepdims=True),
        after / np.linalg.norm(after, axis=1, keepdims=True),
    )
