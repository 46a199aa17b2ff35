"""A decision method: nobody sends costs; each robot matches itself and those it hears with the goals."""

from __future__ import annotations

import numpy as np

from swarm_agent.decision.strategy import Decision, Means
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.plan_motion import goals_at
from swarm_msgs_py.types import FloatArray


class NearestFree:
    """Greedy matching by distance, among the robot and its neighbors.

    The nearest pair of robot and goal is matched first, then the nearest of the rest. Robots that hear each other come
    to the same matching; those that do not may drive to one goal until they meet, and the farther one goes on.

    Parameters
    ----------
    means : Means
    """

    def __init__(self, means: Means) -> None:
        self._means = means

    def step(
        self,
        tick: int,
        position: FloatArray,
        sigma: float,  # noqa: ARG002 - part of the protocol
        takes_part: bool = True,
        is_blocked: bool = False,  # noqa: ARG002
    ) -> Decision:
        """Return the decision for this tick; see `swarm_agent.decision.strategy.Strategy`."""
        plan = self._means.consensus.plan
        if plan is None:
            return Decision(-1, None, Mode.WAITING, self._means.obstacles)
        if not takes_part:
            return Decision(-1, None, Mode.UNASSIGNED, plan.obstacles)
        ids = np.flatnonzero(plan.goal_types == self._means.robot_type.type)
        goals = goals_at(plan, tick)[ids]
        taken = self._matched(position, goals)
        if taken is None:
            return Decision(-1, None, Mode.UNASSIGNED, plan.obstacles)
        return Decision(int(ids[taken]), goals[taken], Mode.TRAVELING, plan.obstacles)

    def _matched(self, position: FloatArray, goals: FloatArray) -> int | None:
        """Return the row of the own goal, None if the others are nearer to all of them."""
        own = self._means.robot_type.type
        rivals = {robot: told.position for robot, told in self._means.mesh.neighbors.items() if told.robot_type == own}
        robots = sorted({*rivals, self._means.robot})
        places = np.array([rivals.get(robot, position) for robot in robots])
        distances = np.linalg.norm(places[:, None] - goals, axis=2)
        while np.isfinite(distances).any():
            robot, goal = np.unravel_index(np.argmin(distances), distances.shape)
            if robots[robot] == self._means.robot:
                return int(goal)
            distances[robot, :] = distances[:, goal] = np.inf
        return None
