"""The mission computer: turns the operator's shape into a plan and sees that every reachable robot gets it."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mission_computer.config import MissionConfig
from mission_computer.dissemination import Dissemination
from mission_computer.membership import Member, Membership, change_line
from mission_computer.move import Move, haste, rest_of
from mission_computer.parking import ParkingWatch
from mission_computer.plan_making import PlanMaker, nearest_inside
from mission_computer.stages import Stage, StageSchedule
from mission_computer.vision.camera_watch import CameraWatch, fixes_of
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError, SwarmError
from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.messages.bodies import Plan, Report, RowRequest, is_newer_epoch
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.messages.camera_report import CameraReport
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.network import make_network
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import contour_at, goals_at
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

_log = logging.getLogger(__name__)


class Mission:
    """The mission computer: no clock, no thread, no I/O.

    Parameters
    ----------
    config : MissionConfig
    network : NetworkConfig
        Settings of its radio.
    roster : Roster
        The robots that a shape is to be filled with.
    obstacles : tuple of (m, 2) array
        Polygons that robots and goals keep clear of [m].
    shape : (k, 2) array
        First shape to form [m].
    period_s : float
        Control period [s].
    bounds : tuple of float or None
        Least x, least y, greatest x, greatest y that a shape may reach [m]; None: no limits.
    stages : sequence of Stage
        Shapes that follow the first.
    markers : sequence of CoverMarker
        By what an overhead camera knows the robots; none: there is no camera.
    heading : float or None
        Direction that the robots are to face in the first shape [rad]; None: that is left to them.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - collaborators and settings that the composition root provides
        self,
        config: MissionConfig,
        network: NetworkConfig,
        roster: Roster,
        obstacles: tuple[FloatArray, ...],
        shape: FloatArray,
        period_s: float,
        bounds: tuple[float, float, float, float] | None = None,
        stages: Sequence[Stage] = (),
        markers: Sequence[CoverMarker] = (),
        heading: float | None = None,
    ) -> None:
        self._config = config
        self._maker = PlanMaker(config.partition, roster, obstacles, bounds, config.asked)
        self._membership = Membership(config, [group.type for group in roster.groups])
        self._network = make_network(MISSION, network, period_s)
        self._dissemination = Dissemination(config)
        self._period = period_s
        self._expected = roster.size
        self._first: Stage | None = Stage(shape, heading=heading)  # not yet planned for
        self._schedule = StageSchedule(stages)
        self._parking = ParkingWatch()
        self._camera = CameraWatch(config.vision, markers) if markers else None
        self._plan: Plan | None = None
        self._course = Course()
        self._body = b""
        self._newest_epoch = 0
        self._corrupt = 0

    def step(self, inputs: MissionInputs) -> MissionOutputs:
        """Advance by one tick."""
        for delivery in self._network.receive(inputs.tick, inputs.inbox):
            self._take(delivery, inputs)
        reachable = tuple(node for node in self._network.reachable if node != MISSION)
        self._watch_mesh(reachable, inputs.time)
        plan, notice = self._replan(inputs)
        if self._plan is not None and self._dissemination.is_due(inputs.time, reachable):
            self._network.flood(self._body)
        seen, said = self._look(inputs)
        outbox = self._network.transmit(inputs.tick, self._presence(inputs.tick))
        notice = "; ".join(filter(None, (notice, said)))
        return MissionOutputs(inputs.tick, outbox, plan, replace(self._report(reachable, notice), camera=seen))

    @property
    def has_camera(self) -> bool:
        """Whether it looks at the robots from above."""
        return self._camera is not None

    def picture(self) -> ImageArray | None:
        """Return the last image with what was read out of it, the shape and the goals; None if there was none yet."""
        return None if self._camera is None else self._camera.picture(self._plan)

    def _look(self, inputs: MissionInputs) -> tuple[CameraReport | None, str]:
        """Tell the robots where the camera sees them; return what it saw, and a line for the operator."""
        if self._camera is None:
            return None, ""
        seen = self._camera.look(inputs.time, inputs.image, inputs.camera)
        fixes = fixes_of(seen, inputs.tick)
        if fixes is not None:
            self._network.flood(encode_body(fixes))
        return seen, self._camera.notice(inputs.time, seen)

    @property
    def _epoch(self) -> int:
        return 0 if self._plan is None else self._plan.epoch

    def _take(self, delivery: Delivery, inputs: MissionInputs) -> None:
        """Act on what another radio sent to this one; rows of costs concern only the robots."""
        try:
            body = decode_body(delivery.body)
        except FrameError:
            self._corrupt += 1
            return
        if isinstance(body, Report):
            self._parking.take(body, inputs.time)
            self._membership.take_report(body, inputs.time, self._destination(body, inputs.tick))
            self._note_epoch(body.robot, body.epoch)
        elif isinstance(body, RowRequest) and self._is_to_be_told(body.epoch, inputs.time):
            self._network.send(delivery.origin, self._body)

    def _is_to_be_told(self, epoch: int, time: float) -> bool:
        """Return whether a robot that holds the plan of `epoch`, and asks, needs an answer."""
        return epoch < self._epoch and not self._dissemination.is_on_its_way(time)

    def _destination(self, report: Report, tick: int) -> FloatArray | None:
        """Return where a robot is driving that reports [m], None if it is not, or speaks of another plan.

        That is its goal; where there are none, the nearest point of the shape.
        """
        plan = self._plan
        if plan is None or report.epoch != plan.epoch:
            return None
        if not plan.task.has_goals:
            return nearest_inside(contour_at(plan, tick), report.position)
        if not 0 <= report.goal < len(plan.goals):
            return None
        goal: FloatArray = goals_at(plan, tick)[report.goal]
        return goal

    def _watch_mesh(self, reachable: tuple[NodeId, ...], time: float) -> None:
        """Note who is there, and which plan the neighbors' hellos show, which is sooner known than their reports."""
        self._membership.take_routes(reachable, time)
        for robot, presence in self._network.neighbors.items():
            self._membership.take_presence(robot, presence, time)
            self._note_epoch(robot, presence.epoch)

    def _note_epoch(self, robot: NodeId, epoch: int) -> None:
        self._dissemination.acknowledge(robot, epoch)
        if is_newer_epoch(epoch, self._newest_epoch):
            self._newest_epoch = epoch

    def _replan(self, inputs: MissionInputs) -> tuple[Plan | None, str]:
        """Return the new plan, if there is cause for one, and a line for the operator."""
        if inputs.shape is not None or (self._first is not None and not self._waits_for_robots(inputs.time)):
            return self._plan_order(inputs)
        if self._plan is None:
            return None, ""
        stage = self._schedule.next_due(inputs.time, self._rested(self._plan, inputs.time), self._formed_at(self._plan))
        if stage is not None:
            return self._plan_stage(stage, inputs)
        if self._newest_epoch > self._plan.epoch:
            # Robots hold a plan of an earlier life of this computer; only a higher number replaces it.
            notice = f"robots hold plan {self._newest_epoch} of an earlier mission computer; sending ours again"
            self._put_in_force(encode_body(self._maker.renumbered(self._plan, self._next_epoch)), inputs)
            return self._plan, notice
        if self._membership.is_regrouping_due(inputs.time):
            return self._plan_members(inputs)
        return None, ""

    def _plan_order(self, inputs: MissionInputs) -> tuple[Plan | None, str]:
        """Plan for the shape that the operator has just ordered, which ends the schedule; at first, the first shape."""
        first, self._first = self._first, None
        if inputs.shape is not None:
            plan, notice = self._plan_shape(Stage(inputs.shape, self._config.morph_s), inputs, "shape refused")
            if plan is not None:
                self._schedule.cancel()
            return plan, notice
        assert first is not None  # what else was there to plan for?
        return self._plan_shape(first, inputs, "shape refused")

    def _waits_for_robots(self, time: float) -> bool:
        """Return whether the first plan is put off until the robots have said where they are."""
        if not self._config.nearest_types or time >= self._config.nearest_wait_s:
            return False
        known = sum(member.position is not None for member in self._membership.members(time))
        return known < self._expected

    def _formed_at(self, plan: Plan) -> float:
        """Return when the shape of a plan is, or was, where it is to be [s]."""
        return plan.motion.ends * self._period if plan.motion is not None else -math.inf

    def _rested(self, plan: Plan, time: float) -> float:
        """Return for how long everybody has been at rest in the shape, below 0 if they are not [s]."""
        robots = self._membership.present(time)
        # Who has not been heard at all by the time that makes a silent robot lost is not waited for.
        expected = self._expected - len(self._membership.lost(time)) if time < self._config.lost_after_s else 0
        return self._parking.rested(time, plan.epoch, self._formed_at(plan), robots, expected)

    def _plan_stage(self, stage: Stage, inputs: MissionInputs) -> tuple[Plan | None, str]:
        """Plan for the next stage of the schedule, which goes no further if that is refused."""
        plan, notice = self._plan_shape(stage, inputs, f"stage {self._schedule.done + 1} refused")
        if plan is None:
            self._schedule.break_off()
        else:
            self._schedule.finish()
        return plan, notice

    def _plan_shape(self, stage: Stage, inputs: MissionInputs, refusal: str) -> tuple[Plan | None, str]:
        """Plan for a shape that was ordered, or for the motion to it; refuse one that cannot be used."""
        lost = self._membership.lost(inputs.time)
        try:
            if self._plan is None or stage.over_s == 0.0:
                near = self._membership.members(inputs.time) if self._config.nearest_types else ()
                plan = self._maker.for_shape(self._next_epoch, stage.contour, lost, near)
            else:
                ticks = max(1, round(stage.over_s / self._period))
                move = Move(stage.contour, self._led(inputs.tick), ticks, self._period, stage.rotation_rad)
                plan = self._maker.for_move(self._next_epoch, move, self._course.at(move.begins), lost)
            body = encode_body(replace(plan, heading=stage.heading))
        except SwarmError as error:
            return None, self._refusal(f"{refusal}: {error}")
        self._membership.account(inputs.time)
        self._put_in_force(body, inputs)
        speed = self._config.robot_speed_m_s
        return self._plan, "" if speed is None else haste(plan, self._period, speed)

    def _led(self, tick: int) -> int:
        """Return the tick in which a motion begins that is ordered in `tick`."""
        return tick + max(1, math.ceil(self._config.lead_s / self._period - 1e-9))

    def _plan_members(self, inputs: MissionInputs) -> tuple[Plan | None, str]:
        """Plan for those who are there now, so that nobody waits for the lost and no goal is where a body stands."""
        time = inputs.time
        lost = self._membership.lost(time)
        change = change_line({member.robot for member in lost}, self._membership.accounted)
        self._membership.account(time)
        try:
            plan = self._moving_members(inputs.tick, lost) or self._maker.for_members(self._next_epoch, lost)
            body = encode_body(replace(plan, heading=None if self._plan is None else self._plan.heading))
        except SwarmError as error:
            return None, self._refusal(f"{change}, but a new plan is not possible: {error}")
        self._put_in_force(body, inputs)
        notice = f"{change}; new plan for {plan.robot_count} robots"
        _log.info(notice)
        return self._plan, notice

    def _moving_members(self, tick: int, lost: Sequence[Member]) -> Plan | None:
        """Return a plan for those who are there to end the motion that is going on; None if none is, or can be."""
        assert self._plan is not None  # members are only lost under a plan
        move = rest_of(self._plan, self._led(tick), self._period)
        if move is None:
            return None
        try:
            return self._maker.for_move(self._next_epoch, move, self._course.at(move.begins), lost)
        except SwarmError as error:
            _log.info("the motion cannot go on: %s", error)
            return None

    @property
    def _next_epoch(self) -> int:
        return max(self._newest_epoch, self._epoch) + 1

    def _refusal(self, cause: str) -> str:
        kept = f"plan {self._epoch} stays in force" if self._plan is not None else "there is no plan yet"
        notice = f"{cause}; {kept}"
        _log.info(notice)
        return notice

    def _put_in_force(self, body: bytes, inputs: MissionInputs) -> None:
        self._body = body
        # Viewers and metrics see exactly what the robots hold: positions in centimeters.
        self._plan = plan = self._maker.as_held(body)
        self._course.put(inputs.tick, plan)
        self._newest_epoch = plan.epoch
        self._dissemination.restart(plan.epoch, inputs.time)
        _log.info("plan %d: %s for %d robots", plan.epoch, plan.task.value, plan.robot_count)

    def _presence(self, tick: int) -> Presence:
        return Presence(
            position=np.array(self._config.position_m),
            velocity=np.zeros(2),
            covariance=np.zeros((2, 2)),
            shared=0.0,
            tick=tick,
            robot_type=0,
            is_beacon=False,
            mode=0,
            epoch=self._epoch,
            digest=0,
        )

    def _report(self, reachable: tuple[NodeId, ...], notice: str) -> MissionReport:
        counters = self._network.counters
        return MissionReport(
            epoch=self._epoch,
            informed=self._dissemination.informed,
            reachable=reachable,
            parked=self._parking.parked(self._epoch),
            notice=notice,
            counters=replace(counters, corrupt=counters.corrupt + self._corrupt),
            stage=self._schedule.done,
            stages_left=self._schedule.left,
            is_broken_off=self._schedule.is_broken_off,
        )
