"""What a robot asks of planning: cost of each goal, way-points to one goal, is the straight line free."""

from __future__ import annotations

from collections import OrderedDict
from functools import lru_cache

import numpy as np

from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.configuration_space import GRAZE, ConfigurationSpace, disc_polygon
from swarm_agent.planning.shortest_path import GoalTable, ShortestPaths
from swarm_agent.planning.visibility_graph import VisibilityGraph
from swarm_msgs_py.types import FloatArray, IntArray

TABLES_KEPT = 512  # goal sets whose tables are remembered; every robot of a process may ask for a goal of its own
PLANNERS_KEPT = 32  # obstacle sets and radii; old plans die out
BOUND_SIDES = 64  # of the inscribed polygon: the bound is low by at most 0.12 % of the radius per turn
COINCIDENT = 1e-9  # way-points nearer to the start than this [m] are the start


class PathPlanner:
    """Shortest paths of one type of robot among one set of obstacles.

    Parameters
    ----------
    obstacles : tuple of (k, 2) array
        Polygons [m].
    disc : (s, 2) array
        Convex polygon that stands for the robot, the origin inside it [m].

    Notes
    -----
    A start inside the forbidden space (a robot pushed into the margin) looks around from the nearest boundary point,
    but moves from where it is, straight to the first way-point. By convexity of the distance, no point of that leg is
    deeper inside than the start, and the robot does not stall at an escape point beside the wall.

    Raises
    ------
    ShapeError
        If an obstacle is not a list of finite points.
    """

    def __init__(self, obstacles: tuple[FloatArray, ...], disc: FloatArray) -> None:
        self.space = ConfigurationSpace(obstacles, disc)
        self.graph = VisibilityGraph(self.space)
        self._paths = ShortestPaths(self.graph)
        self._tables: OrderedDict[bytes, GoalTable] = OrderedDict()

    def costs(self, start: FloatArray, goals: FloatArray) -> FloatArray:
        """Return the length of the shortest path to each goal.

        Parameters
        ----------
        start : (2,) array
            Position of the robot's center [m].
        goals : (m, 2) array
            Positions [m]; the work that depends on them alone is done once per content.

        Returns
        -------
        (m,) array
            Lengths [m]; inf for a goal that is inside an obstacle's margin or walled off.
        """
        direct, nodes, first_legs = self._look_around(start, goals)
        if len(nodes) == 0:
            return direct
        around = first_legs[:, None] + self._table(goals).costs[nodes]
        shortest: FloatArray = np.minimum(direct, around.min(axis=0))
        return shortest

    def path(self, start: FloatArray, goal: FloatArray) -> FloatArray | None:
        """Return the way-points of the shortest path, or None if there is no path.

        Parameters
        ----------
        start, goal : (2,) array
            Positions [m].

        Returns
        -------
        (k, 2) array or None
            Way-points after the start, the goal last, k >= 1 [m]. The polyline from the start is as long as `costs`
            says.
        """
        goals = np.atleast_2d(goal)
        if self.is_clear(start, goal):
            return goals.copy()
        _, nodes, first_legs = self._look_around(start, goals)
        table = self._table(goals)
        lengths = first_legs + table.costs[nodes, 0]
        best = int(lengths.argmin()) if len(nodes) else -1
        if best < 0 or not np.isfinite(lengths[best]):
            return None
        first = int(nodes[best])
        corners = self.graph.nodes[self._paths.between(first, int(table.last_nodes[first, 0]))]
        if first_legs[best] < COINCIDENT:
            corners = corners[1:]
        return np.concatenate((corners, goals))

    def is_clear(self, start: FloatArray, end: FloatArray) -> bool:
        """Return whether the straight segment between two points stays in free space.

        Sliding along an obstacle's margin is free. A start inside the forbidden space is projected out first.
        """
        return self.space.walls.is_clear(self.space.project(start), end)

    def _look_around(self, start: FloatArray, goals: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """Return the straight lengths to the goals (inf if blocked), the visible nodes, the lengths to them."""
        eye = self.space.project(start)
        nodes = self.graph.tangent_nodes(eye)
        ends = np.concatenate((self.graph.nodes[nodes], goals))
        legs = ends - start
        lengths = np.sqrt(legs[:, 0] ** 2 + legs[:, 1] ** 2)
        lengths[~self.space.walls.clear_from(eye, ends)] = np.inf
        first_legs, direct = lengths[: len(nodes)], lengths[len(nodes) :]
        seen = first_legs < np.inf
        return direct, nodes[seen], first_legs[seen]

    def _table(self, goals: FloatArray) -> GoalTable:
        key = goals.tobytes()
        table = self._tables.get(key)
        if table is None:
            table = self._tables[key] = self._paths.to_goals(goals)
            if len(self._tables) > TABLES_KEPT:
                self._tables.popitem(last=False)
        else:
            self._tables.move_to_end(key)
        return table


def planner_for(obstacles: tuple[FloatArray, ...], radius: float, config: PlanningConfig) -> PathPlanner:
    """Return the planner for robots of one coverage radius; equal content gives the same object.

    Parameters
    ----------
    obstacles : tuple of (k, 2) array
        Polygons [m].
    radius : float
        Coverage radius of the robot [m].
    config : PlanningConfig

    Raises
    ------
    ShapeError
        If an obstacle is not a list of finite points.
    """
    return _planner(_content(obstacles), radius + config.clearance_margin_m, config.polygon_sides, False)


def lower_bound_planner(obstacles: tuple[FloatArray, ...], radius: float, sides: int = BOUND_SIDES) -> PathPlanner:
    """Return a planner whose costs no robot of this radius can beat without touching an obstacle.

    Its obstacles are grown by a polygon inside the coverage circle, without margin. Metrics compare with it.
    """
    return _planner(_content(obstacles), radius, sides, True)


def _content(obstacles: tuple[FloatArray, ...]) -> tuple[tuple[tuple[int, ...], bytes], ...]:
    arrays = [np.asarray(obstacle, dtype=np.float64) for obstacle in obstacles]
    return tuple((array.shape, array.tobytes()) for array in arrays)


@lru_cache(maxsize=PLANNERS_KEPT)
def _planner(
    content: tuple[tuple[tuple[int, ...], bytes], ...], reach: float, sides: int, inscribed: bool
) -> PathPlanner:
    obstacles = tuple(np.frombuffer(raw, dtype=np.float64).reshape(shape) for shape, raw in content)
    # The tolerance of the sight test, spent beforehand, may only make the bound smaller.
    reach = max(reach - 2.0 * GRAZE, 0.0) if inscribed else reach
    return PathPlanner(obstacles, disc_polygon(reach, sides, inscribed=inscribed))
