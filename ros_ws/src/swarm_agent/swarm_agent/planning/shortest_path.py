"""Shortest paths over the visibility graph (thesis section 3.4.2, Algorithms 4 and 5).

Obstacles stand still, and all robots of one type drive to the same goals. So everything but a robot's first leg is
known beforehand: Dijkstra runs once per set of obstacles, the legs to the goals are found once per set of goals, and
a robot only has to choose its first corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import dijkstra

from swarm_agent.planning.visibility_graph import VisibilityGraph
from swarm_msgs_py.types import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class GoalTable:
    """Shortest ways from every node of the graph to each goal.

    Attributes
    ----------
    costs : (v, m) array
        Length from a node to a goal [m], inf where there is no path.
    last_nodes : (v, m) int array
        Node from which that path leaves for the goal; meaningless where the cost is inf.
    """

    costs: FloatArray
    last_nodes: IntArray


class ShortestPaths:
    """All shortest paths between the nodes of one visibility graph."""

    def __init__(self, graph: VisibilityGraph) -> None:
        self._graph = graph
        if len(graph.nodes):
            self._lengths, self._previous = dijkstra(graph.edges(), directed=False, return_predecessors=True)
        else:
            self._lengths, self._previous = np.empty((0, 0)), np.empty((0, 0), dtype=np.int32)

    def to_goals(self, goals: FloatArray) -> GoalTable:
        """Return the shortest ways from every node to each of the `goals`, (m, 2) [m].

        A goal inside the forbidden space sees no node, so it cannot be reached.
        """
        shape = (len(self._graph.nodes), len(goals))
        costs, last_nodes = np.full(shape, np.inf), np.full(shape, -1, dtype=np.int64)
        for column, goal in enumerate(goals):
            doors = self._graph.visible_nodes(goal)
            if len(doors) == 0:
                continue
            lengths = self._lengths[:, doors] + np.linalg.norm(self._graph.nodes[doors] - goal, axis=1)
            best = lengths.argmin(axis=1)
            costs[:, column] = lengths[np.arange(len(lengths)), best]
            last_nodes[:, column] = doors[best]
        return GoalTable(costs, last_nodes)

    def between(self, first: int, last: int) -> list[int]:
        """Return the nodes of the shortest path from node `first` to node `last`, both included.

        `last` must be reachable from `first`.
        """
        backwards, previous = [last], self._previous[first]
        while backwards[-1] != first:
            backwards.append(int(previous[backwards[-1]]))
        return backwards[::-1]
