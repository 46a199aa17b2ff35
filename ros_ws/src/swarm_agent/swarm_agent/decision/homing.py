"""Where a lost robot goes: to the middle of the shape, because beacons are likely there (thesis section 3.1.3, E27)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import shapely

from swarm_agent.planning.configuration_space import ConfigurationSpace
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import contour_at
from swarm_msgs_py.types import FloatArray, NodeId

INSIDE_M = 1.0
"""How far inside the contour the home point lies, where the shape is that wide."""

HOME_PERIOD_S = 5.0
"""Time between two looks at where home is, while the shape moves."""

_CORNERS_MIN = 3
_TINY = 1e-9  # [m]
_OFF_M = 0.01  # from the edge of the free space: a robot does not stop on a millimeter
_HALVINGS = 20  # of the inset, for shapes that are narrower than two meters everywhere


class Home:
    """Where home is under the plans that one robot has heard: in the shape as it is by now.

    Parameters
    ----------
    period_s : float
        Control period [s].
    """

    def __init__(self, period_s: float) -> None:
        self._every = max(1, round(HOME_PERIOD_S / period_s))
        self._course = Course()
        self._basis: tuple[int, int, int] | None = None  # what the point follows from
        self._point = np.zeros(2)

    def learn(self, tick: int, plan: Plan) -> None:
        """Take note of a newer plan."""
        self._course.put(tick, plan)

    def point(self, tick: int, plan: Plan, space: ConfigurationSpace) -> FloatArray:
        """Return the home point, (2,) [m]; in a shape that moves, what it was at most `HOME_PERIOD_S` ago.

        Parameters
        ----------
        tick : int
        plan : Plan
            The newest one, learned before. Its motion may be yet to begin; then the one before it says where the shape
            is.
        space : ConfigurationSpace
            Where the robot may be.
        """
        present = self._course.at(tick)
        motion = present.motion
        stretch = -1 if motion is None or tick >= motion.ends else max(tick - motion.begins, 0) // self._every
        basis = plan.epoch, present.epoch, stretch
        if basis != self._basis:
            try:
                contour = contour_at(present, tick)
            except ShapeError:  # a motion that cannot be, of a forged plan
                contour = present.contour
            self._basis, self._point = basis, home_point(contour, space)
        return self._point


def home_point(contour: FloatArray, space: ConfigurationSpace | None = None) -> FloatArray:
    """Return the point to which lost robots return, shape (2,) [m].

    The center of the boundary (thesis eq. (3.65)) if it lies at least `INSIDE_M` inside the contour and is free,
    otherwise the nearest point that does and is. In a shape too thin for that, the margin is halved until some point
    keeps it. Where no point inside the shape is free, the nearest free one outside has to do.

    Parameters
    ----------
    contour : (k, 2) array
        Simple closed polygon [m]. If it is none, because a plan was forged, the mean of its corners is taken, or the
        origin if it has none.
    space : ConfigurationSpace or None
        Where the robot may be; None: everywhere. The body of a dead robot is an obstacle of later plans, and may lie
        where home was.
    """
    if not _is_simple(contour):
        middle: FloatArray = contour.mean(axis=0) if len(contour) else np.zeros(2)
        return middle if space is None else space.project(middle)
    shape = shapely.Polygon(contour)
    center = shape.exterior.centroid
    is_free = space is None or space.is_free(shapely.get_coordinates(center)[0])
    clearance = shape.exterior.distance(center) if shape.contains(center) and is_free else -1.0
    taken = shapely.Polygon() if space is None else space.forbidden.buffer(_OFF_M)
    margin = INSIDE_M
    for _ in range(_HALVINGS):
        if clearance >= margin - _TINY:  # an inset loses places that keep the margin exactly
            break
        inner = shape.buffer(-margin).difference(taken)
        if not inner.is_empty:
            nearest = shapely.get_coordinates(shapely.shortest_line(inner, center))[0]
            return np.asarray(nearest)
        margin /= 2.0
    inside = shapely.get_coordinates(center if clearance >= 0.0 else shape.representative_point())[0]
    return inside if space is None else space.project(inside)


def _is_simple(contour: FloatArray) -> bool:
    if len(contour) < _CORNERS_MIN:
        return False
    shape = shapely.Polygon(contour)
    return bool(shape.is_valid) and shape.area > 0.0


def home_destination(
    robot: NodeId,
    position: FloatArray,
    home: FloatArray,
    neighbors: Iterable[tuple[NodeId, Presence]],
    spacing: float,
) -> FloatArray | None:
    """Return where a robot on its way home goes now: home, or nowhere if another one has that place.

    Parameters
    ----------
    robot : NodeId
    position : (2,) array
        Own estimate [m].
    home : (2,) array
        Home point [m].
    neighbors : iterable of (NodeId, Presence)
        Radio neighbors; those that return home as well are kept away from.
    spacing : float
        Least distance between robots that have returned home [m]; who is nearer to the home point, or else of lower
        address, has precedence.
    """
    own = (float(np.hypot(*(position - home))), robot)
    for neighbor, presence in neighbors:
        if presence.mode != Mode.RETURN_HOME:
            continue
        its = (float(np.hypot(*(presence.position - home))), neighbor)
        if its < own and float(np.hypot(*(presence.position - position))) < spacing:
            return None
    return home
