"""The way of one type of robot into a shape: around obstacles, to a place where its whole body is inside."""

from __future__ import annotations

import numpy as np

from swarm_agent.planning.path_planner import PathPlanner
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.partition.free_region import FreeRegion, free_region
from swarm_msgs_py.types import FloatArray

_DOORS = 48  # points of the inset contour among which a robot behind an obstacle looks for the nearest
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)  # of the inset that are tried in shapes that are too narrow for all of it

_MARGIN_MIN = 0.01  # [m]; without a margin, obstacles push from this depth on at full force


class Ground:
    """The inset of a shape, and the ways to it.

    Parameters
    ----------
    contour : (k, 2) array
        Shape [m].
    inset : float
        Distance that the robot's center is to keep from the contour, where the shape is wide enough [m].
    planner : PathPlanner
        Of the robot's free space.
    margin : float
        Gap between obstacles and the robot's body that this free space leaves [m].
    """

    def __init__(self, contour: FloatArray, inset: float, planner: PathPlanner, margin: float) -> None:
        self._planner = planner
        self._margin = max(margin, _MARGIN_MIN)
        self._region = _widest(contour, inset)
        corners = self._region.starts
        self._doors: FloatArray = corners[:: max(1, len(corners) // _DOORS)].copy()

    def eye(self, position: FloatArray) -> FloatArray:
        """Return where a robot looks around from: `position` itself, or the nearest place out of obstacles' margins.

        Parameters
        ----------
        position : (2,) array
            Center of the robot [m].

        Returns
        -------
        (2,) array
            The same object if it is free [m].
        """
        return self._planner.space.project(position)

    def way(self, position: FloatArray, eye: FloatArray, wanted: FloatArray | None) -> tuple[FloatArray, bool]:
        """Return where to go from here.

        Parameters
        ----------
        position : (2,) array
            Center of the robot [m].
        eye : (2,) array
            Where it looks around from; see `eye` [m].
        wanted : (2,) array or None
            Where it is wanted, to be brought into the inset; None: at the point of the inset to which the shortest path
            from here leads [m].

        Returns
        -------
        way : (2,) array
            To the next corner of the path, or to its end [m]; zero if there is no path.
        is_last : bool
            Whether that is the end of the path.
        """
        target = self._region.nearest(position if wanted is None else wanted)
        if self._planner.space.walls.is_clear(eye, target):
            return target - position, True
        if wanted is None:
            target = self._doors[int(self._planner.costs(position, self._doors).argmin())]
        path = self._planner.path(position, target)
        if path is None:
            return np.zeros(2), True
        return path[0] - position, len(path) == 1

    def trespass(self, position: FloatArray, eye: FloatArray) -> FloatArray:
        """Return the way out of the margin around obstacles, (2,), in units of the margin and at most as long as it."""
        way = (eye - position) / self._margin
        shortened: FloatArray = way / max(1.0, float(np.hypot(way[0], way[1])))
        return shortened


def _widest(contour: FloatArray, inset: float) -> FreeRegion:
    """Return the inset of a contour, or the deepest one that leaves something of it.

    Raises
    ------
    ShapeError
        If there is nothing inside the contour.
    """
    for share in _SHARES:
        region = free_region(contour, (), share * inset, 0.0, 0.0)
        if not region.is_empty:
            return region
    raise ShapeError("there is nothing inside the contour")
