"""The mission computer: turns the operator's shape into a plan and sees that every reachable robot gets it."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from mission_computer.config import MissionConfig
from mission_computer.dissemination import Dissemination
from mission_computer.partition import partition
from mission_computer.roster import Roster
from mission_computer.shape import load_shape
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError, ShapeError
from swarm_msgs_py.messages.bodies import Plan, Report, RowRequest
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.messages.report import MissionReport, Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

EPOCH_MAX = 2**31  # an epoch beyond this was not counted up to by any mission computer: it is noise

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
    seed : int
        Seed of the run, for partition methods that draw.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - collaborators and settings that the composition root provides
        self,
        config: MissionConfig,
        network: NetworkConfig,
        roster: Roster,
        obstacles: tuple[FloatArray, ...],
        shape: FloatArray,
        period_s: float,
        seed: int,
    ) -> None:
        self._config = config
        self._roster = roster
        self._obstacles = obstacles
        self._seed = seed
        self._network = MeshNetwork(MISSION, network, period_s)
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
            self._take(delivery)
        self._watch_neighbors()
        plan, notice = self._replan(inputs)
        reachable = tuple(node for node in self._network.reachable if node != MISSION)
        if self._plan is not None and self._dissemination.is_due(inputs.time, reachable):
            self._network.flood(self._body)
        outbox = self._network.transmit(inputs.tick, self._presence())
        return MissionOutputs(inputs.tick, outbox, plan, self._report(reachable, notice))

    @property
    def _epoch(self) -> int:
        return 0 if self._plan is None else self._plan.epoch

    def _take(self, delivery: Delivery) -> None:
        """Act on what another radio sent to this one; rows of costs concern only the robots."""
        try:
            body = decode_body(delivery.body)
        except FrameError:
            self._corrupt += 1
            return
        if isinstance(body, Report):
            self._reports[body.robot] = body
            self._note_epoch(body.robot, body.epoch)
        elif isinstance(body, RowRequest) and self._plan is not None and body.epoch < self._plan.epoch:
            self._network.send(delivery.origin, self._body)

    def _watch_neighbors(self) -> None:
        """Read from the neighbors' hellos which plan they hold, which is sooner known than their reports."""
        for robot, presence in self._network.neighbors.items():
            self._note_epoch(robot, presence.epoch)

    def _note_epoch(self, robot: NodeId, epoch: int) -> None:
        self._dissemination.acknowledge(robot, epoch)
        if epoch < EPOCH_MAX:
            self._newest_epoch = max(self._newest_epoch, epoch)

    def _replan(self, inputs: MissionInputs) -> tuple[Plan | None, str]:
        """Return the new plan, if there is cause for one, and a line for the operator."""
        if inputs.shape is not None:
            self._ordered = inputs.shape
        if self._ordered is not None:
            shape, self._ordered = self._ordered, None
            try:
                self._put_in_force(self._made_plan(shape), inputs.time)
            except ShapeError as error:
                kept = f"plan {self._epoch} stays in force" if self._plan is not None else "there is no plan yet"
                notice = f"shape refused: {error}; {kept}"
                _log.warning(notice)
                return None, notice
            return self._plan, ""
        if self._plan is not None and self._newest_epoch > self._plan.epoch:
            # Robots hold a plan of an earlier life of this computer; only a higher number replaces it.
            notice = f"robots hold plan {self._newest_epoch} of an earlier mission computer; sending ours again"
            self._put_in_force(replace(self._plan, epoch=self._newest_epoch + 1), inputs.time)
            return self._plan, notice
        return None, ""

    def _made_plan(self, shape: FloatArray) -> Plan:
        """Return the plan for a shape, computed on the numbers that the robots will see.

        Raises
        ------
        ShapeError
            If the shape cannot be used.
        """
        contour = load_shape(load_shape(shape).astype(np.float32).astype(np.float64))
        goals = partition(contour, self._roster, self._obstacles, self._config.partition, seed=self._seed)
        epoch = max(self._newest_epoch, self._epoch) + 1
        return Plan(epoch, contour, self._obstacles, goals.positions, goals.types)

    def _put_in_force(self, plan: Plan, time: float) -> None:
        self._body = encode_body(plan)
        # Viewers and metrics see exactly what the robots decode: positions as float32.
        decoded = decode_body(self._body)
        assert isinstance(decoded, Plan)  # the type that was encoded
        self._plan = decoded
        self._newest_epoch = decoded.epoch
        self._dissemination.restart(decoded.epoch, time)
        _log.info("plan %d: %d goals", decoded.epoch, len(decoded.goals))

    def _presence(self) -> Presence:
        return Presence(
            position=np.array(self._config.position_m),
            velocity=np.zeros(2),
            sigma=0.0,
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
