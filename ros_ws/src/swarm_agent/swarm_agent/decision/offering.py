"""Which cost row a robot offers, and when.

A robot offers its costs once per plan, and anew when a robot of its type joins and it has moved since. That is enough:
who follows a shortest path to its goal makes that goal cheaper by every meter driven, and no other goal by more. So an
assignment that was best stays best in any mixture of old and fresh rows, and late rows flip nobody's goal.

A robot that takes no part offers no costs. Its row keeps the goal that it had: that one costs nothing, the others
cannot be reached. What is best for the rest of the robots and goals is then what it was before, so nobody else changes.
Who has no goal to keep, or keeps one that another robot could use, offers an empty row.
"""

from __future__ import annotations

from enum import Enum, auto

import numpy as np

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.messages.bodies import UNREACHABLE, Plan
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, IntArray, NodeId

_CM_PER_M = 100.0


class Row(Enum):
    """Kinds of cost rows."""

    COSTS = auto()
    RESERVATION = auto()
    EMPTY = auto()


class RowOffers:
    """Offers the cost rows of one robot.

    Parameters
    ----------
    robot, robot_type
        Who offers, and its type.
    config, planning
        Settings of the decision and of the path costs.
    mesh : MeshNetwork
        The robot's radio network, which carries the rows.
    consensus : Consensus
        The robot's copy of plan and rows.
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
        period_s: float,
    ) -> None:
        self._robot = robot
        self._type = robot_type
        self._config = config
        self._planning = planning
        self._mesh = mesh
        self._consensus = consensus
        self._pause = max(1, round(config.refresh_pause_s / period_s))
        self._spread = max(1, round(config.refresh_spread_s / period_s))
        self._epoch = 0
        self._kind: Row | None = None
        self._version = 0  # of the row offered last
        self._offered_at = 0  # tick
        self._offered_from: FloatArray | None = None
        self._members: frozenset[NodeId] = frozenset()
        self._members_at: int | None = None  # digest of the rows that the members were read from
        self._is_stale = False  # others have joined, and the last row is from elsewhere

    def step(self, tick: int, plan: Plan, position: FloatArray, goal: int, *, takes_part: bool) -> None:
        """Offer a row if one is due.

        Parameters
        ----------
        tick : int
        plan : Plan
            In force.
        position : (2,) array
            Own estimate [m].
        goal : int
            Goal id that the robot has now, -1 for none.
        takes_part : bool
            Whether the robot is there for a goal.
        """
        if plan.epoch != self._epoch:
            self._epoch, self._kind, self._version = plan.epoch, None, 0
            self._members, self._members_at, self._is_stale = frozenset(), None, False
        self._watch_members(position)
        kind = self._due(tick, plan, goal, takes_part=takes_part)
        if kind is not None:
            self._offer(tick, plan, position, goal, kind)

    def _watch_members(self, position: FloatArray) -> None:
        """Note robots that join: costs from another place than the present one would misjudge what to give them."""
        book = self._consensus.book
        if book.digest == self._members_at:
            return
        members = frozenset(row.robot for row in book.of_type(self._type.type))
        joined = members - self._members - {self._robot}
        self._members, self._members_at = members, book.digest
        if joined and self._offered_from is not None and self._kind is not None:
            moved = float(np.hypot(*(position - self._offered_from)))
            self._is_stale = self._is_stale or moved >= self._config.refresh_distance_m

    def _due(self, tick: int, plan: Plan, goal: int, *, takes_part: bool) -> Row | None:
        """Return the kind of row to offer now, None if the last one is good."""
        book = self._consensus.book
        if not takes_part:
            is_needed = book.answered(self._type.type) > int((plan.goal_types == self._type.type).sum())
            wanted = Row.RESERVATION if goal >= 0 and not is_needed else Row.EMPTY
            # Once given up, a goal is not taken back: it may be on its way to another robot.
            is_good = self._kind in {wanted, Row.EMPTY}
            return None if is_good and self._is_known() else (Row.EMPTY if self._kind is Row.EMPTY else wanted)
        if self._kind in {None, Row.EMPTY} or not self._is_known() or (self._kind is Row.RESERVATION and goal < 0):
            return Row.COSTS
        is_turn = (tick + self._robot) % self._spread == 0 and tick - self._offered_at >= self._pause
        return Row.COSTS if self._is_stale and is_turn else None

    def _is_known(self) -> bool:
        """Return whether the own row in the book is the last one offered, not one of an earlier life of this robot."""
        return self._consensus.book.version_of(self._robot) == self._version

    def _offer(self, tick: int, plan: Plan, position: FloatArray, goal: int, kind: Row) -> None:
        self._consensus.offer(tick, self._row(plan, position, goal, kind), self._mesh)
        self._kind, self._version = kind, self._consensus.book.version_of(self._robot)
        self._offered_at, self._offered_from = tick, position.copy()
        self._is_stale = False

    def _row(self, plan: Plan, position: FloatArray, goal: int, kind: Row) -> IntArray:
        """Return the costs of the goals of the own type [cm], (m,); (0,) for an empty row."""
        if kind is Row.EMPTY:
            return np.empty(0, dtype=np.int64)
        goals = np.flatnonzero(plan.goal_types == self._type.type)
        if kind is Row.RESERVATION:
            return np.where(goals == goal, 0, UNREACHABLE)
        costs = self._costs(plan, position)
        kept = (goals == goal) & (costs != UNREACHABLE)
        costs[kept] = np.maximum(costs[kept] - round(self._config.keep_goal_m * _CM_PER_M), 0)
        return costs

    def _costs(self, plan: Plan, position: FloatArray) -> IntArray:
        """Return the path length to each goal of the own type [cm].

        An estimate that is far off may lie in a wall or outside the arena, from where no path leads anywhere. The robot
        is somewhere else for certain; then beelines are the best guess.
        """
        planner = planner_for(plan.obstacles, self._type.coverage_radius_m, self._planning)
        goals = plan.goals[plan.goal_types == self._type.type]
        meters = planner.costs(position, goals)
        if not np.isfinite(meters).any():
            meters = np.linalg.norm(goals - position, axis=1)
        centimeters = np.minimum(np.rint(meters * _CM_PER_M), UNREACHABLE - 1)
        return np.where(np.isfinite(meters), centimeters, UNREACHABLE).astype(np.int64)
