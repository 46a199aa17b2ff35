"""One robot of the swarm: no clock, no thread, no I/O."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter

import numpy as np

from swarm_agent.config import AgentConfig
from swarm_agent.control.avoidance import Avoidance
from swarm_agent.control.facing import Facing
from swarm_agent.control.path_follower import PathFollower
from swarm_agent.control.wall_following import WallFollowing
from swarm_agent.control.yielding import make_way
from swarm_agent.decision.by_task import ByTask
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.goal_seeking import GoalSeeking
from swarm_agent.decision.homing import Home, home_destination
from swarm_agent.decision.strategy import Decision, Means, Strategy
from swarm_agent.energy import EnergyStore
from swarm_agent.forces.forming import ForceForming
from swarm_agent.localization.camera_fixes import CameraFixReceiver, SeenFrom
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.heading import Heading
from swarm_agent.localization.hypotheses import widest
from swarm_agent.localization.localizer import Localizer
from swarm_agent.localization.positioning import PositioningMonitor, Signs
from swarm_agent.planning.path_planner import PathPlanner, planner_for
from swarm_msgs_py.binary import COORDINATE_MAX
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.extensions import STRATEGIES, extension
from swarm_msgs_py.messages.bodies import Plan, Report
from swarm_msgs_py.messages.control import STOP, VelocityCommand
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Delivery, Presence
from swarm_msgs_py.messages.report import AgentReport, LocalizationReport, Mode, Positioning
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix
from swarm_msgs_py.networking.network import make_network
from swarm_msgs_py.orientation import rotation
from swarm_msgs_py.partition import PartitionConfig
from swarm_msgs_py.plan_goals import goals_crc
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.step_io import AgentInputs, AgentOutputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

_IS_BEACON = attrgetter("is_beacon")
_ORIGIN, _NO_IDEA = np.zeros(2), np.eye(2) * SIGMA_UNKNOWN**2
_ORIGIN.flags.writeable = _NO_IDEA.flags.writeable = False


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
    start : PositionFix or None
        Where the robot was told to stand at the start; None: it has to find out.
    partition : PartitionConfig or None
        How to find the goals of a plan that leaves them to the robots, as the mission computer has it; None: defaults.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - what one robot is and has been told
        self,
        robot: NodeId,
        config: AgentConfig,
        robot_type: RobotType,
        period_s: float,
        obstacles: tuple[FloatArray, ...] = (),
        start: PositionFix | None = None,
        partition: PartitionConfig | None = None,
    ) -> None:
        self.id = robot
        self._config = config
        self._type = robot_type
        self._report_every = max(1, round(config.decision.report_period_s / period_s))
        self._localizer = Localizer(config.lps, period_s, start, obstacles)
        self._monitor = PositioningMonitor(config.lps, period_s)
        self._heading = Heading(config.lps, period_s)
        self._camera = CameraFixReceiver(robot) if config.lps.from_camera else None
        self._blind_after = round(config.lps.blind_after_s / period_s)
        self._mesh = make_network(robot, config.network, period_s)
        self._consensus = Consensus(robot, robot_type.type, config.decision, period_s, partition)
        self._energy = EnergyStore(config.energy, period_s)
        goals = GoalSeeking(
            robot,
            robot_type,
            config=config.decision,
            planning=config.planning,
            mesh=self._mesh,
            consensus=self._consensus,
            energy=self._energy,
            obstacles=obstacles,
            period_s=period_s,
        )
        forces = ForceForming(
            robot, robot_type, config=config.forces, planning=config.planning, mesh=self._mesh, period_s=period_s
        )
        self._strategy: Strategy = ByTask(self._consensus, goals, forces)
        if config.decision.strategy is not None:
            means = Means(
                robot, robot_type, period_s, config.decision, config.planning, self._mesh, self._consensus, obstacles
            )
            self._strategy = extension(STRATEGIES, config.decision.strategy)(means)
        self._period = period_s
        self._facing = Facing(config.control)
        self._follower = PathFollower(config.control, period_s, robot_type.coverage_radius_m)
        radius, margin = robot_type.coverage_radius_m, config.control.avoidance.margin_m
        self._wall_following = WallFollowing(radius, margin, period_s)
        self._avoidance = Avoidance(config.control.avoidance, robot_type.coverage_radius_m, period_s)
        self._planner: PathPlanner | None = None
        self._mapped: tuple[FloatArray, ...] = ()
        self._learned: Plan | None = None
        self._goals_crc = 0  # of the goals in that plan
        self._reported_epoch = 0
        self._beacons = 0  # among the neighbors
        self._disagreements = 0
        self._told: VelocityCommand | None = None  # the last command
        self._is_blind = False
        self._home = Home(period_s)

    @property
    def plan(self) -> Plan | None:
        """The plan in force, with the goals that it left the robots to find."""
        return self._consensus.plan

    def step(self, inputs: AgentInputs) -> AgentOutputs:
        """Advance by one tick: the whole flow of one robot, top to bottom."""
        tick, mesh = inputs.tick, self._mesh
        deliveries = mesh.receive(tick, inputs.inbox)
        imu, seen = self._sense(inputs, deliveries)
        to_world = rotation(self._localizer.heading(imu))
        around = inputs.proximity @ to_world.T
        estimate = self._localizer.step(
            tick,
            imu,
            inputs.fix,
            inputs.ranges,
            mesh.neighbors,
            proximity=around,
            told=None if self._told is None else to_world @ (self._told.forward, self._told.left),
            is_blocked=self._avoidance.is_blocked,
            seen=seen,
        )
        if estimate is not None and not _can_be_told(estimate):
            estimate = None
        positioning = self._positioning(inputs, estimate)
        self._consensus.receive(tick, deliveries, mesh)
        self._consensus.repair(tick, mesh)
        self._learn(tick, self._consensus.plan)
        if estimate is None:
            decision, command = None, STOP
        else:
            decision = self._decide(tick, estimate, positioning)
            command = self._control(estimate, decision, around, to_world)
        self._told = command
        self._energy.spend(command)
        mode, is_held_up = self._mode(decision)
        self._report(tick, estimate, decision, mode)
        outbox = mesh.transmit(tick, self._presence(tick, estimate, mode, asks_for_way=is_held_up))
        return AgentOutputs(tick, command, outbox, self._state(estimate, decision, mode))

    def _sense(self, inputs: AgentInputs, deliveries: Sequence[Delivery]) -> tuple[ImuSample, SeenFrom | None]:
        """Return the inertial sample with the heading that the robot believes in, and what the camera says of it."""
        if self._camera is None:
            return inputs.imu, None
        seen = self._camera.take(inputs.tick, deliveries)
        seen_at = self._camera.seen_at
        self._is_blind = seen_at is None or inputs.tick - seen_at > self._blind_after
        turn_rate = 0.0 if self._told is None else self._told.yaw_rate
        yaw = self._heading.step(inputs.tick, inputs.imu.yaw, turn_rate, seen)
        return replace(inputs.imu, yaw=yaw), seen

    def _learn(self, tick: int, plan: Plan | None) -> None:
        """Tell the localizer what a new plan says of walls and bodies; take down its goals and where home is."""
        if plan is not None and plan is not self._learned:
            self._localizer.learn(plan.walls, plan.body_outlines)
            self._learned, self._goals_crc = plan, goals_crc(plan.goals, plan.goal_types)
            self._home.learn(tick, plan)

    def _positioning(self, inputs: AgentInputs, estimate: Estimate | None) -> Positioning:
        """Return whether the robot knows where it is; count beacons that the hellos and the routes see differently."""
        neighbors = self._mesh.neighbors
        self._beacons = sum(map(_IS_BEACON, neighbors.values()))
        if len(inputs.ranges.neighbors):
            routes = (self._mesh.route(neighbor) for neighbor, presence in neighbors.items() if presence.is_beacon)
            self._disagreements += sum(1 for route in routes if route is None or route.hops != 1)
        sigma = math.inf if estimate is None else widest(estimate.covariance)
        is_corrected = estimate is not None and estimate.is_corrected
        return self._monitor.step(inputs.tick, Signs(self._beacons, self._localizer.is_beacon, is_corrected, sigma))

    def _decide(self, tick: int, estimate: Estimate, positioning: Positioning) -> Decision:
        """Return where to go: where the swarm's decision says, or home if the robot has been lost for too long."""
        is_lost = positioning is Positioning.RETURN_HOME
        decision = self._strategy.step(
            tick, estimate.position, _sigma(estimate), takes_part=not is_lost, is_blocked=self._avoidance.is_blocked
        )
        plan = self._consensus.plan
        if not is_lost or plan is None:
            return decision  # without a plan there is no shape to return to: the strategy goes and finds one
        home = self._home.point(tick, plan, self._planner_for(plan.obstacles).space)
        spacing = self._config.lps.lost.spacing_m
        target = home_destination(self.id, estimate.position, home, self._mesh.neighbors.items(), spacing)
        return Decision(-1, target, Mode.RETURN_HOME, decision.obstacles)

    def _control(
        self, estimate: Estimate, decision: Decision, around: FloatArray, to_world: FloatArray
    ) -> VelocityCommand:
        """Return the body-frame command that follows the path, or the forces, and keeps clear of what is near."""
        planner = self._planner_for(decision.obstacles)
        wanted = self._follower.step(
            planner, estimate.position, decision.destination, _sigma(estimate), around, decision.drift
        )
        path = self._follower.path
        reach = float(np.hypot(*(path[0] - estimate.position))) if len(path) else 0.0
        if decision.drift is not None:
            reach = max(reach, float(np.hypot(*wanted)) * self._period)  # where it is bound for moves on
        if decision.velocity is not None:
            # Forces look at others farther ahead themselves; they are asked again in a tick.
            wanted, reach = decision.velocity, float(np.hypot(*decision.velocity)) * self._period
        wanted = self._wall_following.step(wanted, self._localizer.walls)
        aside = self._step_aside(estimate, decision)
        if aside is not None:
            wanted, reach = aside, self._config.control.yielding.displacement_max_m
        if self._is_blind:
            wanted, reach = _ORIGIN, 0.0
        safe = self._avoidance.step(wanted, estimate.velocity, around, reach) @ to_world
        plan = self._consensus.plan
        turn = 0.0 if self._is_blind else self._facing.turn_rate(estimate.yaw, None if plan is None else plan.heading)
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
        asking = [p.position for p in self._mesh.neighbors.values() if p.asks_for_way]
        if not asking:
            return None
        return make_way(estimate.position, decision.destination, np.array(asking), self._config.control.yielding)

    def _mode(self, decision: Decision | None) -> tuple[Mode, bool]:
        """Return what the robot does, and whether it hardly gets on with it; others must know who returns home."""
        if decision is None:
            return Mode.WAITING, False
        if self._is_blind:
            return Mode.BLIND, False
        if decision.mode is Mode.PARKED or (decision.goal >= 0 and self._follower.is_parked):
            return Mode.PARKED, False
        is_moving = decision.destination is not None or decision.velocity is not None
        is_held_up = is_moving and self._avoidance.is_blocked
        if is_held_up and decision.mode is not Mode.RETURN_HOME:
            return Mode.BLOCKED, True
        return decision.mode, is_held_up

    def _report(self, tick: int, estimate: Estimate | None, decision: Decision | None, mode: Mode) -> None:
        """Tell the mission computer how things stand, now and then and as soon as a new plan is held."""
        epoch = self._consensus.book.epoch
        is_due = (tick + self.id) % self._report_every == 0
        if estimate is None or decision is None or not (is_due or epoch != self._reported_epoch):
            return
        x, y = (float(c) for c in estimate.position)
        report = Report(self.id, self._type.type, epoch, decision.goal, (x, y), int(mode), _sigma(estimate))
        if self._mesh.send(MISSION, encode_body(report)):
            self._reported_epoch = epoch

    def _presence(self, tick: int, estimate: Estimate | None, mode: Mode, *, asks_for_way: bool) -> Presence:
        book = self._consensus.book
        return Presence(
            position=estimate.position if estimate else _ORIGIN,
            velocity=estimate.velocity if estimate else _ORIGIN,
            covariance=estimate.covariance if estimate else _NO_IDEA,
            shared=estimate.shared if estimate else 0.0,
            tick=tick,
            robot_type=self._type.type,
            is_beacon=self._localizer.is_beacon,
            mode=int(mode),
            epoch=book.epoch,
            digest=book.digest,
            asks_for_way=asks_for_way,
        )

    def _state(self, estimate: Estimate | None, decision: Decision | None, mode: Mode) -> AgentReport:
        neighbors = self._mesh.neighbors
        monitor, localizer = self._monitor, self._localizer
        return AgentReport(
            position=estimate.position if estimate else np.full(2, np.nan),
            velocity=estimate.velocity if estimate else np.zeros(2),
            covariance=estimate.covariance if estimate else _NO_IDEA,
            yaw=self._localizer.yaw,
            mode=mode,
            localization=LocalizationReport(
                positioning=monitor.state,
                lost_by_beacons=monitor.lost_by_beacons,
                lost_by_sigma=monitor.lost_by_sigma,
                shared=estimate.shared if estimate else 0.0,
                accepted=localizer.accepted,
                rejected=localizer.rejected,
                disagreements=self._disagreements,
            ),
            epoch=self._consensus.book.epoch,
            goal=decision.goal if decision else -1,
            path=self._follower.path,
            neighbors=tuple(neighbors),
            beacons=self._beacons,
            routes=len(self._mesh.reachable),
            rows=len(self._consensus.book),
            counters=self._mesh.counters,
            goals_crc=self._goals_crc,
        )


def _can_be_told(estimate: Estimate) -> bool:
    """Return whether a radio can tell an estimate; who hears beacons beyond the edge of the world knows nothing."""
    state = np.concatenate((estimate.position, estimate.velocity))
    return bool((np.abs(state) <= COORDINATE_MAX).all() and np.isfinite(estimate.covariance).all())


def _sigma(estimate: Estimate) -> float:
    """Return the standard deviation of a position estimate, root mean square of both axes [m]."""
    return math.sqrt((float(estimate.covariance[0, 0]) + float(estimate.covariance[1, 1])) / 2.0)
