"""The decision of methods with goals (thesis 3.2.2): every robot solves the same assignment and takes its own goal."""

from __future__ import annotations

import numpy as np

from swarm_agent.decision.assignment import assign
from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.strategy import Decision
from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.messages.bodies import UNREACHABLE, Plan
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, IntArray, NodeId

_CM_PER_M = 100.0


class GoalSeeking:
    """Cost row out, everybody's rows in, assignment, goal.

    Parameters
    ----------
    robot, robot_type
        Who decides, and its type.
    config, planning
        Settings of the decision and of the path costs.
    mesh : MeshNetwork
        The robot's radio network, which carries the rows.
    consensus : Consensus
        The robot's copy of plan and rows.
    obstacles : tuple of (m, 2) array
        Map known from the start, until a plan brings another [m].
    period_s : float
        Control period [s].
    """

    def __init__(  # noqa: PLR0913 - collaborators, each named at the one place of construction
        self,
        robot: NodeId,
        robot_type: RobotType,
        *,
        config: DecisionConfig,
        planning: PlanningConfig,
        mesh: MeshNetwork,
        consensus: Consensus,
        obstacles: tuple[FloatArray, ...],
        period_s: float,
    ) -> None:
        self._robot = robot
        self._type = robot_type
        self._config = config
        self._planning = planning
        self._mesh = mesh
        self._consensus = consensus
        self._first_map = obstacles
        self._patience = round(config.patience_s / period_s)
        self._rally_after = round(config.rally_after_s / period_s)
        self._rally_point = np.array(config.rally_point_m or (0.0, 0.0))
        self._epoch = 0
        self._epoch_since = 0
        self._members: frozenset[NodeId] = frozenset()
        self._members_at = -1  # digest of the rows that the members were read from
        self._offered_from: FloatArray | None = None  # position at which the own row was computed
        # Epoch, digest and whether patience is over: what the goal follows from.
        self._decided_on: tuple[int, int, bool] | None = None
        self._goal = -1
        self._is_undecided = True
        self._destination: FloatArray | None = None  # the last goal taken, of this plan or an older one

    def step(self, tick: int, position: FloatArray) -> Decision:
        """Return where to go; sends the own cost row when the plan or the membership makes it necessary."""
        plan = self._consensus.plan
        if plan is None:
            searching = tick >= self._rally_after
            target = self._rally_point if searching else None
            return Decision(-1, target, Mode.SEARCHING if searching else Mode.WAITING, self._first_map)
        if plan.epoch != self._epoch:
            self._epoch, self._epoch_since, self._goal = plan.epoch, tick, -1
            self._is_undecided = True
            self._offered_from = None
            self._members, self._members_at = frozenset(), -1
        if self._offered_from is None or self._consensus.book.digest != self._members_at:
            self._offer_if_needed(tick, plan, position)
        self._decide(tick, plan)
        if self._goal >= 0:
            self._destination = plan.goals[self._goal]
            return Decision(self._goal, self._destination, Mode.TRAVELING, plan.obstacles)
        if self._is_undecided:
            # Until the rows for a new plan are complete, what the old one wanted is the best guess (spec 11.5).
            return Decision(-1, self._destination, Mode.UNASSIGNED, plan.obstacles)
        return Decision(-1, None, Mode.UNASSIGNED, plan.obstacles)

    def _offer_if_needed(self, tick: int, plan: Plan, position: FloatArray) -> None:
        """Send a cost row for a new plan, and a fresh one for newcomers if the robot has moved since the last."""
        book = self._consensus.book
        members = frozenset(row.robot for row in book.of_type(self._type.type))
        joined = members - self._members - {self._robot}
        self._members, self._members_at = members, book.digest
        if self._offered_from is not None:
            moved = float(np.hypot(*(position - self._offered_from)))
            if not joined or moved < self._config.refresh_distance_m:
                return
        self._offered_from = position.copy()
        self._consensus.offer(tick, self._costs(plan, position), self._mesh)

    def _costs(self, plan: Plan, position: FloatArray) -> IntArray:
        planner = planner_for(plan.obstacles, self._type.coverage_radius_m, self._planning)
        meters = planner.costs(position, plan.goals[plan.goal_types == self._type.type])
        centimeters = np.minimum(np.rint(meters * _CM_PER_M), UNREACHABLE)
        return np.asarray(centimeters, dtype=np.int64)

    def _decide(self, tick: int, plan: Plan) -> None:
        """Take the goal that the assignment gives, once the rows are complete or patience is over."""
        book = self._consensus.book
        patience_over = tick - self._epoch_since >= self._patience
        basis = (plan.epoch, book.digest, patience_over)
        if basis == self._decided_on:
            return
        self._decided_on = basis
        rows = book.of_type(self._type.type)
        goals = np.flatnonzero(plan.goal_types == self._type.type)
        if len(rows) >= len(goals) or patience_over:
            self._is_undecided = False
            taken = assign(rows).get(self._robot)
            self._goal = -1 if taken is None else int(goals[taken])
