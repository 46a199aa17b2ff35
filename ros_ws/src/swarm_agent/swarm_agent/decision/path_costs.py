"""What the goals of a plan cost a robot: path lengths in whole steps, centimeters by default, as rows carry them."""

from __future__ import annotations

import numpy as np

from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.messages.bodies import UNREACHABLE, Plan
from swarm_msgs_py.plan_motion import goals_at
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, IntArray

STEP_M = 0.01
"""Step of path lengths where nothing else is set [m]."""


class PathCosts:
    """Path lengths of one type of robot.

    Parameters
    ----------
    robot_type : RobotType
    config : PlanningConfig
    step_m : float
        In which they are told [m].
    """

    def __init__(self, robot_type: RobotType, config: PlanningConfig, step_m: float = STEP_M) -> None:
        self._type = robot_type
        self._config = config
        self._per_m = 1.0 / step_m

    @property
    def robot_type(self) -> int:
        """Number of the type."""
        return self._type.type

    def steps(self, length_m: float) -> int:
        """Return a length [m] in whole steps."""
        return round(length_m * self._per_m)

    def goals(self, plan: Plan) -> IntArray:
        """Return the ids of the goals for this type, ascending, (m,)."""
        return np.flatnonzero(plan.goal_types == self._type.type)

    def places(self, tick: int, plan: Plan) -> FloatArray:
        """Return where the goals for this type are, (m, 2) [m]; those that are about to move, where they begin."""
        places: FloatArray = goals_at(plan, tick)[self.goals(plan)]
        return places

    def origins(self, plan: Plan) -> FloatArray:
        """Return where the goals for this type are before a plan has moved any of them, (m, 2) [m]."""
        return self.places(0 if plan.motion is None else plan.motion.begins, plan)

    def of(self, tick: int, plan: Plan, position: FloatArray) -> IntArray:
        """Return the length of the shortest path from a place to where each goal of the type is now, (m,) [steps].

        As `to` of `places`.
        """
        return self.to(self.places(tick, plan), plan, position)

    def to(self, goals: FloatArray, plan: Plan, position: FloatArray) -> IntArray:
        """Return the length of the shortest path from a place to each of some others, (m,) [steps].

        An estimate that is far off may lie in a wall or outside the arena, from where no path leads anywhere. The robot
        is somewhere else for certain; then beelines are the best guess.

        Parameters
        ----------
        goals : (m, 2) array
            Where to [m].
        plan : Plan
            Whose obstacles are in the way.
        position : (2,) array
            The place [m].
        """
        planner = planner_for(plan.obstacles, self._type.coverage_radius_m, self._config)
        meters = planner.costs(position, goals)
        if not np.isfinite(meters).any():
            meters = np.linalg.norm(goals - position, axis=1)
        steps = np.minimum(np.rint(meters * self._per_m), UNREACHABLE - 1)
        return np.where(np.isfinite(meters), steps, UNREACHABLE).astype(np.int64)


def dearer(costs: IntArray, surcharge: IntArray | int) -> IntArray:
    """Return costs with something added [steps], at least 0; what has no path still has none, and only that."""
    changed = np.clip(costs + surcharge, 0, UNREACHABLE - 1)
    return np.where(costs == UNREACHABLE, UNREACHABLE, changed)
