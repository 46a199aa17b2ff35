"""The decision of methods with goals (thesis 3.2.2): every robot solves the same assignment and takes its own goal."""

from __future__ import annotations

import numpy as np

from swarm_agent.decision.aim import Aim
from swarm_agent.decision.assignment import agreed_objective, assign
from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.departure import early_destination
from swarm_agent.decision.offering import RowOffers
from swarm_agent.decision.path_costs import PathCosts
from swarm_agent.decision.strategy import Decision
from swarm_agent.decision.swapping import SwapOffers
from swarm_agent.energy import EnergyStore
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.messages.bodies import Objective, Plan
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.network import Network
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import goals_at, outline_at
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

SAME_M = 0.001  # [m]; plans travel in whole centimeters


class GoalSeeking:
    """Cost row out, everybody's rows in, assignment, goal.

    Parameters
    ----------
    robot, robot_type
        Who decides, and its type.
    config, planning
        Settings of the decision and of the path costs.
    mesh : Network
        The robot's radio network, which carries the rows.
    consensus : Consensus
        The robot's copy of plan and rows.
    energy : EnergyStore
        What the robot has left; it counts in the weight of its costs.
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
        mesh: Network,
        consensus: Consensus,
        energy: EnergyStore,
        obstacles: tuple[FloatArray, ...],
        period_s: float,
    ) -> None:
        self._robot = robot
        self._type = robot_type
        self._mesh = mesh
        self._consensus = consensus
        self._first_map = obstacles
        paths = PathCosts(robot_type, planning, config.cost_step_m)
        self._offers = RowOffers(
            robot, config=config, paths=paths, energy=energy, mesh=mesh, consensus=consensus, period_s=period_s
        )
        self._swaps = SwapOffers(robot, config.swap, paths, mesh, consensus, period_s)
        self._period = period_s
        self._patience = round(config.patience_s / period_s)
        self._settle = round(config.settle_s / period_s)
        self._rally_after = round(config.rally_after_s / period_s)
        self._rally_point = np.array(config.rally_point_m or (0.0, 0.0))
        self._epoch = 0
        self._since, self._since_tick = 0, 0  # epoch with which the rows began, and when that plan was heard
        # Epoch, digest and whether patience is over: what the goal follows from.
        self._decided_on: tuple[int, int, bool] | None = None
        self._goal = -1
        self._taken: dict[NodeId, int] = {}  # what the rows say of everybody
        self._proposed, self._proposed_at = -1, 0  # what the rows say, and since which tick
        self._is_undecided = True
        self._in_touch_at = 0  # last tick that began with a goal of this robot, or with a way to hear of one
        self._course = Course()  # the plans with the goal ids of the one in force
        self._aim: Aim | None = None  # the last goal taken
        self._departure: FloatArray | None = None  # where to set out for until there is one
        self._contour = np.empty((0, 2))  # the shape of the plan in force

    def step(self, tick: int, position: FloatArray, takes_part: bool = True, is_blocked: bool = False) -> Decision:
        """Return where to go; sends the own cost row when the plan or the membership makes it necessary.

        Parameters
        ----------
        tick : int
        position : (2,) array
            Own estimate [m].
        takes_part : bool
            False while the robot has something else to do: it withdraws and has no goal to drive to. The goal that it
            had stays reserved, and is its own again when it is back. Without a plan it looks for one all the same.
        is_blocked : bool
            Whether the robot is hardly getting on; if another one is in its way for long, it offers to exchange goals.
        """
        plan = self._consensus.plan
        if self._goal >= 0 or MISSION in self._mesh.reachable:
            self._in_touch_at = tick
        if plan is None:
            searching = tick >= self._rally_after
            target = self._rally_point if searching else None
            return Decision(-1, target, Mode.SEARCHING if searching else Mode.WAITING, self._first_map)
        if self._consensus.book.since != self._since:
            self._begin(tick, plan, position)
        elif plan.epoch != self._epoch:
            self._go_on(tick, plan)
        self._offers.step(tick, plan, position, self._goal, takes_part=takes_part)
        if takes_part and self._proposed == self._goal:
            surcharge = self._swaps.step(tick, plan, position, self._taken, is_blocked=is_blocked)
            if surcharge is not None:
                self._offers.offer_swap(tick, plan, position, self._goal, surcharge)
        self._decide(tick, plan)
        if not takes_part:
            return Decision(-1, None, Mode.UNASSIGNED, plan.obstacles)
        if self._goal >= 0:
            self._aim = Aim(self._course, self._goal)
        if self._goal >= 0 or self._is_undecided:
            place, drift = (self._departure, None) if self._aim is None else self._aim.at(tick, self._period)
            mode = Mode.TRAVELING if self._goal >= 0 else Mode.UNASSIGNED
            return Decision(self._goal, place, mode, plan.obstacles, drift=drift)
        if tick - self._in_touch_at >= self._rally_after:  # no newer plan can reach the robot where it is
            return Decision(-1, self._rally_point, Mode.SEARCHING, plan.obstacles)
        return Decision(-1, None, Mode.UNASSIGNED, plan.obstacles)

    def _begin(self, tick: int, plan: Plan, position: FloatArray) -> None:
        """Take note of a new plan.

        Until its rows are complete, what the old plan wanted is the best guess if the shape is the same (spec 11.5), or
        moves on from where that one will be.
        """
        self._epoch, self._since, self._since_tick, self._goal = plan.epoch, self._consensus.book.since, tick, -1
        self._is_undecided, self._taken = True, {}
        has_guess = self._aim is not None or self._departure is not None
        if not (has_guess and self._goes_on_from(plan)):
            goals = goals_at(plan, tick)[plan.goal_types == self._type.type]
            self._aim, self._departure = None, early_destination(position, goals)
        self._course = Course()
        self._course.put(tick, plan)
        self._contour = plan.contour

    def _goes_on_from(self, plan: Plan) -> bool:
        """Return whether a plan has the shape that is in force, or moves it on; who has missed a plan holds another."""
        motion = plan.motion
        if motion is None:
            return np.array_equal(plan.contour, self._contour)
        try:
            held = outline_at(self._course.at(motion.begins), motion.begins)
        except (LookupError, ShapeError):
            return False
        return held.shape == motion.start.shape and bool(np.allclose(held, motion.start, rtol=0.0, atol=SAME_M))

    def _go_on(self, tick: int, plan: Plan) -> None:
        """Take note of a plan that moves the goals on: whose goal is which stays as it is."""
        self._epoch, self._contour = plan.epoch, plan.contour
        self._course.put(tick, plan)

    def _decide(self, tick: int, plan: Plan) -> None:
        """Take the goal that the assignment gives, once the rows are complete or patience is over.

        Another goal than the one taken must be what the rows say for a while: a burst of rows arrives one by one, and
        each of the sets in between may say something else.
        """
        self._propose(tick, plan)
        if self._is_undecided or self._proposed == self._goal:
            return
        if self._goal < 0 or tick - self._proposed_at >= self._settle:
            self._goal = self._proposed

    def _propose(self, tick: int, plan: Plan) -> None:
        """Solve the assignment if anything has changed that it follows from."""
        book = self._consensus.book
        patience_over = tick - self._since_tick >= self._patience
        basis = (plan.epoch, book.digest, patience_over)
        if basis == self._decided_on:
            return
        self._decided_on = basis
        if not (patience_over or not self._is_undecided or self._is_complete(plan)):
            return
        self._taken = assign(book.offers)
        taken = self._taken.get(self._robot)
        goal = -1 if taken is None else int(np.flatnonzero(plan.goal_types == self._type.type)[taken])
        if self._is_undecided or goal != self._proposed:
            self._proposed, self._proposed_at = goal, tick
        self._is_undecided = False

    def _is_complete(self, plan: Plan) -> bool:
        """Return whether all rows are there that bear on the own goal: the longest path may be one of another type."""
        book = self._consensus.book
        is_shared = agreed_objective(book.offers) is Objective.BOTTLENECK
        return book.is_complete(sorted(set(plan.goal_types.tolist())) if is_shared else [self._type.type])
