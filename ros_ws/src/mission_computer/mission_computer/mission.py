"""The mission computer: turns the operator's shape into a plan and sees that every reachable robot gets it."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from mission_computer.config import MissionConfig
from mission_computer.dissemination import Dissemination
from mission_computer.membership import Membership, change_line
from mission_computer.plan_making import PlanMaker, nearest_inside
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError, SwarmError
from swarm_msgs_py.messages.bodies import Plan, Report, RowRequest, is_newer_epoch
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.messages.report import MissionReport, Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.network import make_network
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
    ) -> None:
        self._config = config
        self._maker = PlanMaker(config.partition, roster, obstacles, bounds, config.asked)
        self._membership = Membership(config, [group.type for group in roster.groups])
        self._network = make_network(MISSION, network, period_s)
        self._dissemination = Dissemination(config)
        self._ordered: FloatArray | None = shape
        self._plan: Plan | None = None
        self._body = b""
        self._reports: dict[NodeId, Report] = {}
        self._newest_epoch = 0
        self._corrupt = 0

    def step(self, inputs: MissionInputs) -> MissionOutputs:
        """Advance by one tick."""
        for delivery in self._network.receive(inputs.tick, inputs.inbox):
            self._take(delivery, inputs.time)
        reachable = tuple(node for node in self._network.reachable if node != MISSION)
        self._watch_mesh(reachable, inputs.time)
        plan, notice = self._replan(inputs)
        if self._plan is not None and self._dissemination.is_due(inputs.time, reachable):
            self._network.flood(self._body)
        outbox = self._network.transmit(inputs.tick, self._presence(inputs.tick))
        return MissionOutputs(inputs.tick, outbox, plan, self._report(reachable, notice))

    @property
    def _epoch(self) -> int:
        return 0 if self._plan is None else self._plan.epoch

    def _take(self, delivery: Delivery, time: float) -> None:
        """Act on what another radio sent to this one; rows of costs concern only the robots."""
        try:
            body = decode_body(delivery.body)
        except FrameError:
            self._corrupt += 1
            return
        if isinstance(body, Report):
            self._reports[body.robot] = body
            self._membership.take_report(body, time, self._destination(body))
            self._note_epoch(body.robot, body.epoch)
        elif isinstance(body, RowRequest) and self._is_to_be_told(body.epoch, time):
            self._network.send(delivery.origin, self._body)

    def _is_to_be_told(self, epoch: int, time: float) -> bool:
        """Return whether a robot that holds the plan of `epoch`, and asks, needs an answer."""
        return epoch < self._epoch and not self._dissemination.is_on_its_way(time)

    def _destination(self, report: Report) -> FloatArray | None:
        """Return where a robot is driving that reports [m], None if it is not, or speaks of another plan.

        That is its goal; where there are none, the nearest point of the shape.
        """
        plan = self._plan
        if plan is None or report.epoch != plan.epoch:
            return None
        if not plan.task.has_goals:
            return nearest_inside(plan.contour, report.position)
        if not 0 <= report.goal < len(plan.goals):
            return None
        goal: FloatArray = plan.goals[report.goal]
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
        if inputs.shape is not None:
            self._ordered = inputs.shape
        if self._ordered is not None:
            shape, self._ordered = self._ordered, None
            return self._plan_shape(shape, inputs.time)
        if self._plan is None:
            return None, ""
        if self._newest_epoch > self._plan.epoch:
            # Robots hold a plan of an earlier life of this computer; only a higher number replaces it.
            notice = f"robots hold plan {self._newest_epoch} of an earlier mission computer; sending ours again"
            self._put_in_force(encode_body(self._maker.renumbered(self._plan, self._next_epoch)), inputs.time)
            return self._plan, notice
        if self._membership.is_regrouping_due(inputs.time):
            return self._plan_members(inputs.time)
        return None, ""

    def _plan_shape(self, shape: FloatArray, time: float) -> tuple[Plan | None, str]:
        """Plan for a shape that was ordered; refuse one that cannot be used."""
        try:
            body = encode_body(self._maker.for_shape(self._next_epoch, shape, self._membership.lost(time)))
        except SwarmError as error:
            return None, self._refusal(f"shape refused: {error}")
        self._membership.account(time)
        self._put_in_force(body, time)
        return self._plan, ""

    def _plan_members(self, time: float) -> tuple[Plan | None, str]:
        """Plan for those who are there now, so that nobody waits for the lost and no goal is where a body stands."""
        lost = self._membership.lost(time)
        change = change_line({member.robot for member in lost}, self._membership.accounted)
        self._membership.account(time)
        try:
            plan = self._maker.for_members(self._next_epoch, lost)
            body = encode_body(plan)
        except SwarmError as error:
            return None, self._refusal(f"{change}, but a new plan is not possible: {error}")
        self._put_in_force(body, time)
        notice = f"{change}; new plan for {plan.robot_count} robots"
        _log.info(notice)
        return self._plan, notice

    @property
    def _next_epoch(self) -> int:
        return max(self._newest_epoch, self._epoch) + 1

    def _refusal(self, cause: str) -> str:
        kept = f"plan {self._epoch} stays in force" if self._plan is not None else "there is no plan yet"
        notice = f"{cause}; {kept}"
        _log.info(notice)
        return notice

    def _put_in_force(self, body: bytes, time: float) -> None:
        self._body = body
        # Viewers and metrics see exactly what the robots hold: positions in centimeters.
        self._plan = plan = self._maker.as_held(body)
        self._newest_epoch = plan.epoch
        self._dissemination.restart(plan.epoch, time)
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
        parked = (
            robot
            for robot, report in sorted(self._reports.items())
            if report.mode == Mode.PARKED and report.epoch == self._epoch
        )
        counters = self._network.counters
        return MissionReport(
            epoch=self._epoch,
            informed=self._dissemination.informed,
            reachable=reachable,
            parked=tuple(parked),
            notice=notice,
            counters=replace(counters, corrupt=counters.corrupt + self._corrupt),
        )
