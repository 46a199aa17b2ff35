"""Method A as a strategy: what a plan without goals makes of a robot."""

from __future__ import annotations

import logging

import shapely

from swarm_agent.decision.strategy import Decision
from swarm_agent.forces.config import ForceConfig, ForceLawName
from swarm_agent.forces.strategy import ForceStrategy
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.network import Network
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_goals import GEOMETRY_ERRORS
from swarm_msgs_py.plan_motion import contour_at
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, NodeId, robot_name

LAWS = {Task.FORCES: ForceLawName.SHARING, Task.FORCES_LITERAL: ForceLawName.LITERAL}
"""The law of each task that has no goals."""

_log = logging.getLogger(__name__)


class ForceForming:
    """Lets the forces of the plan's shape drive the robot, and says when it has come to rest there.

    Parameters
    ----------
    robot, robot_type
        Who is driven, and its type.
    config : ForceConfig
    planning : PlanningConfig
        How far paths keep from obstacles.
    mesh : Network
        The robot's radio network, whose hellos tell where the neighbors are.
    period_s : float
        Control period [s].
    """

    def __init__(  # noqa: PLR0913 - collaborators, each named at the one place of construction
        self,
        robot: NodeId,
        robot_type: RobotType,
        *,
        config: ForceConfig,
        planning: PlanningConfig,
        mesh: Network,
        period_s: float,
    ) -> None:
        self._robot = robot
        self._type = robot_type
        self._config = config
        self._planning = planning
        self._mesh = mesh
        self._period = period_s
        self._ahead = config.foresight_s / period_s
        self._plan: Plan | None = None
        self._course = Course()
        self._forces: ForceStrategy | None = None  # of that plan; None if it is of no use
        self._contour: FloatArray | None = None  # in force; of a shape that moves, another one each tick
        self._shape = shapely.Polygon()

    def step(self, tick: int, position: FloatArray, sigma: float, plan: Plan, *, takes_part: bool) -> Decision:
        """Return how to move.

        Parameters
        ----------
        tick : int
        position : (2,) array
            Own estimate [m].
        sigma : float
            Its standard deviation, per axis [m].
        plan : Plan
            In force; its task is one of `LAWS`.
        takes_part : bool
            False while the robot has something else to do.
        """
        if plan is not self._plan:
            self._begin(tick, plan)
        velocity = self._velocity(tick, position, sigma, plan) if takes_part else None
        if velocity is None or self._forces is None:
            return Decision(-1, None, Mode.UNASSIGNED, plan.obstacles)
        is_there = self._forces.is_at_rest and bool(shapely.contains_xy(self._shape, position[0], position[1]))
        return Decision(-1, None, Mode.PARKED if is_there else Mode.TRAVELING, plan.obstacles, velocity)

    def _begin(self, tick: int, plan: Plan) -> None:
        """Take note of a new plan, which says how large the robots of each type are."""
        groups = plan.roster.groups if plan.roster is not None else ()
        radii = {group.type: group.coverage_radius_m for group in groups}
        self._plan = plan
        self._course.put(tick, plan)
        self._forces = ForceStrategy(LAWS[plan.task], self._config, self._planning, self._type, radii, self._period)

    def _velocity(self, tick: int, position: FloatArray, sigma: float, plan: Plan) -> FloatArray | None:
        """Return the velocity that the forces ask for; None if nothing follows from the plan's polygons."""
        if self._forces is None:
            return None
        try:
            seen = tick + self._ahead
            contour = contour_at(self._course.at(seen), seen)
            if contour is not self._contour:
                self._contour, self._shape = contour, shapely.Polygon(contour)
                shapely.prepare(self._shape)
            return self._forces.step(tick, position, self._mesh.neighbors, contour, plan.obstacles, sigma)
        except GEOMETRY_ERRORS as error:
            self._forces = None
            name = robot_name(self._robot)
            _log.warning("%s stays where it is: no forces follow from plan %d (%s)", name, plan.epoch, error)
            return None
