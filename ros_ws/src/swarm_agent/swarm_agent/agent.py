"""One robot of the swarm: no clock, no thread, no I/O."""

from __future__ import annotations

import math
from operator import attrgetter

import numpy as np

from swarm_agent.config import AgentConfig
from swarm_agent.control.avoidance import Avoidance
from swarm_agent.control.path_follower import PathFollower
from swarm_agent.control.yielding import make_way
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.goal_seeking import GoalSeeking
from swarm_agent.decision.strategy import Decision, Strategy
from swarm_agent.localization.localizer import Estimate, Localizer
from swarm_agent.planning.path_planner import PathPlanner, planner_for
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import Report
from swarm_msgs_py.messages.control import STOP, VelocityCommand
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.report import AgentReport, Mode
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.step_io import AgentInputs, AgentOutputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

UNKNOWN_SIGMA = 1000.0
"""Standard deviation [m] that a robot claims while it has no idea where it is."""


_IS_BEACON = attrgetter("is_beacon")
_ORIGIN = np.zeros(2)
_ORIGIN.flags.writeable = False


class Agent:
    """One robot: sense, localize, listen, decide, control, speak.

    Parameters
    ----------
    robot : NodeId
        Its address.
    config : AgentConfig
    robot_type : RobotType
        Its mechanics; goals are made for a type.
    period_s : float
        Control period [s].
    obstacles : tuple of (m, 2) array
        Map known before a plan brings one [m].
    """

    def __init__(
        self,
        robot: NodeId,
        config: AgentConfig,
        robot_type: RobotType,
        period_s: float,
        obstacles: tuple[FloatArray, ...] = (),
    ) -> None:
        self.id = robot
        self._config = config
        self._type = robot_type
        self._report_every = max(1, round(config.decision.report_period_s / period_s))
        self._localizer = Localizer(config.lps, period_s)
        self._mesh = MeshNetwork(robot, config.network, period_s)
        self._consensus = Consensus(robot, robot_type.type, config.decision, period_s)
        self._strategy: Strategy = GoalSeeking(
            robot,
            robot_type,
            config=config.decision,
            planning=config.planning,
            mesh=self._mesh,
            consensus=self._consensus,
            obstacles=obstacles,
            period_s=period_s,
        )
        self._follower = PathFollower(config.control, period_s)
        self._avoidance = Avoidance(config.control.avoidance, robot_type.coverage_radius_m, period_s)
        self._planner: PathPlanner | None = None
        self._mapped: tuple[FloatArray, ...] = ()
        self._has_sensor = False
        self._reported_epoch = 0

    def step(self, inputs: AgentInputs) -> AgentOutputs:
        """Advance by one tick: the whole flow of one robot, top to bottom."""
        estimate = self._localizer.step(inputs.imu, inputs.fix)
        self._has_sensor = self._has_sensor or inputs.fix is not None
        self._consensus.receive(inputs.tick, self._mesh.receive(inputs.tick, inputs.inbox), self._mesh)
        self._consensus.repair(inputs.tick, self._mesh)
        if estimate is None:
            decision, command = None, STOP
        else:
            decision = self._strategy.step(inputs.tick, estimate.position)
            command = self._control(estimate, decision, inputs.proximity)
        mode = self._mode(decision)
        self._report(inputs.tick, estimate, decision, mode)
        outbox = self._mesh.transmit(inputs.tick, self._presence(estimate, mode))
        return AgentOutputs(inputs.tick, command, outbox, self._state(inputs, estimate, decision, mode))

    def _control(self, estimate: Estimate, decision: Decision, proximity: FloatArray) -> VelocityCommand:
        """Return the body-frame command that follows the path and keeps clear of what is near."""
        planner = self._planner_for(decision.obstacles)
        wanted = self._follower.step(planner, estimate.position, decision.destination, _sigma(estimate))
        path = self._follower.path
        reach = float(np.hypot(*(path[0] - estimate.position))) if len(path) else 0.0
        aside = self._step_aside(estimate, decision)
        if aside is not None:
            wanted, reach = aside, self._config.control.yielding.displacement_max_m
        cos, sin = math.cos(estimate.yaw), math.sin(estimate.yaw)
        to_world = np.array([[cos, -sin], [sin, cos]])
        safe = self._avoidance.step(wanted, estimate.velocity, proximity @ to_world.T, reach) @ to_world
        turn = -self._config.control.heading_gain_1_s * math.remainder(estimate.yaw, math.tau)
        return VelocityCommand(float(safe[0]), float(safe[1]), turn)

    def _planner_for(self, obstacles: tuple[FloatArray, ...]) -> PathPlanner:
        """Return the planner of the map in force; looked up only when that is another one."""
        if self._planner is None or obstacles is not self._mapped:
            self._planner = planner_for(obstacles, self._type.coverage_radius_m, self._config.planning)
            self._mapped = obstacles
        return self._planner

    def _step_aside(self, estimate: Estimate, decision: Decision) -> FloatArray | None:
        """Return the velocity that makes way for a blocked neighbor, None if this robot has its own way to go."""
        if decision.destination is None or self._avoidance.is_blocked or len(self._follower.path) > 1:
            return None
        asking = [p.position for p in self._mesh.neighbors.values() if p.mode == Mode.BLOCKED]
        if not asking:
            return None
        return make_way(estimate.position, decision.destination, np.array(asking), self._config.control.yielding)

    def _mode(self, decision: Decision | None) -> Mode:
        if decision is None:
            return Mode.WAITING
        if decision.goal >= 0 and self._follower.is_parked:
            return Mode.PARKED
        if decision.destination is not None and self._avoidance.is_blocked:
            return Mode.BLOCKED
        return decision.mode

    def _report(self, tick: int, estimate: Estimate | None, decision: Decision | None, mode: Mode) -> None:
        """Tell the mission computer how things stand, now and then and as soon as a new plan is held."""
        epoch = self._consensus.book.epoch
        is_due = (tick + self.id) % self._report_every == 0
        if estimate is None or decision is None or not (is_due or epoch != self._reported_epoch):
            return
        x, y = (float(c) for c in estimate.position)
        report = Report(self.id, self._type.type, epoch, decision.goal, (x, y), int(mode))
        if self._mesh.send(MISSION, encode_body(report)):
            self._reported_epoch = epoch

    def _presence(self, estimate: Estimate | None, mode: Mode) -> Presence:
        book = self._consensus.book
        return Presence(
            position=estimate.position if estimate else _ORIGIN,
            velocity=estimate.velocity if estimate else _ORIGIN,
            sigma=_sigma(estimate) if estimate else UNKNOWN_SIGMA,
            robot_type=self._type.type,
            is_beacon=self._has_sensor,
            mode=int(mode),
            epoch=book.epoch,
            digest=book.digest,
        )

    def _state(
        self, inputs: AgentInputs, estimate: Estimate | None, decision: Decision | None, mode: Mode
    ) -> AgentReport:
        neighbors = self._mesh.neighbors
        return AgentReport(
            position=estimate.position if estimate else np.full(2, np.nan),
            velocity=estimate.velocity if estimate else np.zeros(2),
            covariance=estimate.covariance if estimate else np.eye(2) * UNKNOWN_SIGMA**2,
            yaw=inputs.imu.yaw,
            mode=mode,
            epoch=self._consensus.book.epoch,
            goal=decision.goal if decision else -1,
            path=self._follower.path,
            neighbors=tuple(neighbors),
            beacons=sum(map(_IS_BEACON, neighbors.values())),
            routes=len(self._mesh.reachable),
            rows=len(self._consensus.book),
            counters=self._mesh.counters,
        )


def _sigma(estimate: Estimate) -> float:
    """Return the standard deviation of a position estimate, root mean square of both axes [m]."""
    return math.sqrt((float(estimate.covariance[0, 0]) + float(estimate.covariance[1, 1])) / 2.0)
