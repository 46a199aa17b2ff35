"""How all robots come to hold the same plan and the same cost rows, over a radio that loses frames.

Two mechanisms: a *flood* brings every record to everyone once, fast; *anti-entropy* repairs what the flood lost. Every
hello carries the epoch and a digest of the rows held. A robot whose own rows have been at rest for a while, and whose
neighbor still shows another digest, asks that neighbor for what it lacks; likewise one whose neighbor has had a newer
plan for a while. Who is asked by a robot that holds rows of the same versions, and still shows another digest, sends
all that it has: two rows go by one number. Records merge in any order, so the swarm ends at one common set wherever it
is connected, also after a partition has healed.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from itertools import islice

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.rows import RowBook, checksum
from swarm_msgs_py.body_codec import decode_body, encode_body, row_size
from swarm_msgs_py.errors import FrameError, ShapeError
from swarm_msgs_py.messages.bodies import (
    VERSION_LEAP_MAX,
    WEIGHT_ONE,
    CostRow,
    Plan,
    RowBundle,
    RowRequest,
    Task,
    is_newer_epoch,
)
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.networking.network import Network
from swarm_msgs_py.partition import PartitionConfig
from swarm_msgs_py.plan_goals import completed, goals_crc
from swarm_msgs_py.types import EVERYONE, IntArray, NodeId, robot_name

BUNDLE_SIZE = 1000
"""Bytes of cost rows in one packet (at least one row): about what a radio sends in a few hundredths of a second."""

BUNDLES_PER_REQUEST, BUNDLES_PER_TICK = 8, 16
"""Packets of rows that answer one request, and all requests of one tick; what is left waits for the next request."""

HAND_ON_PAUSES, REPAIR_PAUSES_MAX = 4, 4
"""Repair periods before the plan is given again to who asks again, and at most between two requests without effect."""

VERSION_MAX = 0xFFFF
"""Largest version of a row: it travels as 16 bits."""

CROWD = 3
"""Neighbors that ask for the plan in one tick, from which on it is flooded: one transmission serves them all."""

_log = logging.getLogger(__name__)


class Consensus:
    """One robot's copy of the common knowledge, and the protocol that keeps it common.

    Parameters
    ----------
    robot : NodeId
        Whose copy.
    robot_type : int
        Its type number.
    config : DecisionConfig
    period_s : float
        Control period [s].
    partition : PartitionConfig or None
        Tuning with which to find the goals of a plan that leaves them to the robots; None for the defaults.

    Attributes
    ----------
    book : RowBook
    is_contested : bool
        Whether somebody holds a row of this robot that it has not sent, and that its own does not outbid; it is from
        an earlier life of the robot, or forged. The next offer outbids it.
    """

    def __init__(
        self,
        robot: NodeId,
        robot_type: int,
        config: DecisionConfig,
        period_s: float,
        partition: PartitionConfig | None = None,
    ) -> None:
        self._robot = robot
        self._robot_type = robot_type
        self._objective = config.objective
        self._partition = partition or PartitionConfig()
        self._repair_after = max(1, round(config.repair_after_s / period_s))
        self._repair_period = max(1, round(config.repair_period_s / period_s))
        self._plan_wait = round(config.plan_wait_s / period_s)
        self._ahead_since: int | None = None  # tick since which some neighbor has a newer plan
        self._offered = 0  # own rows of the plan in force
        self._sent = 0  # checksum of the last of them
        self.is_contested = False
        self._changed_at = 0  # tick of the last change of the book
        self._asked_at = -self._repair_period
        self._bundles_left = BUNDLES_PER_TICK
        self._repair_pause = self._repair_period  # grows while requests are of no avail
        self._handed_on: dict[NodeId, int] = {}  # tick in which a robot, or everyone, was last given the plan
        self.book = RowBook()

    @property
    def plan(self) -> Plan | None:
        """The newest plan heard, with the goals that it leaves the robots to find."""
        return self.book.plan

    def receive(self, tick: int, deliveries: Sequence[Delivery], mesh: Network) -> None:
        """Merge what the mesh delivered; answer requests of neighbors."""
        self._bundles_left = BUNDLES_PER_TICK
        asking: list[NodeId] = []
        for delivery in deliveries:
            try:
                body = decode_body(delivery.body)
            except FrameError:
                continue  # a newer software's record, or damage that the frame's checksum missed
            if isinstance(body, Plan):
                before = self.book.since
                is_newer = self.book.is_news(body) and self.book.adopt(self._completed(body))
                if is_newer:
                    self._handed_on.clear()
                if self.book.since != before:
                    self._offered, self.is_contested = 0, False
                self._note(tick, changed=is_newer)
            elif isinstance(body, CostRow):
                self._take(tick, body)
            elif isinstance(body, RowBundle):
                for row in body.rows:
                    self._take(tick, row)
            elif isinstance(body, RowRequest):
                if body.epoch < self.book.epoch:
                    asking.append(delivery.origin)
                self._answer(tick, delivery.origin, body, mesh)
        self._hand_on(tick, asking, mesh)

    def offer(self, tick: int, costs: IntArray, mesh: Network, weight: int = WEIGHT_ONE) -> None:
        """Publish the own costs [steps] for the plan in force, and the weight; nothing after the last version."""
        version = self.book.version_of(self._robot) + 1
        if version > VERSION_MAX:
            return
        self._offered += 1
        row = CostRow(self.book.epoch, self._robot, self._robot_type, version, costs, weight, self._objective)
        self._sent, self.is_contested = checksum(row), False
        self._note(tick, changed=self.book.put(row))
        mesh.flood(encode_body(row))

    def repair(self, tick: int, mesh: Network) -> None:
        """Ask one neighbor for what it holds and this robot lacks, if there is such a neighbor."""
        epoch, digest = self.book.epoch, self.book.digest
        others = {n: its for n, its in mesh.neighbors.items() if its.epoch != epoch or its.digest != digest}
        ahead = [neighbor for neighbor, its in others.items() if is_newer_epoch(its.epoch, epoch)]
        if not ahead:
            self._ahead_since = None
        elif self._ahead_since is None:
            self._ahead_since, self._repair_pause = tick, self._repair_period
        if tick - self._asked_at < self._repair_pause:
            return
        if self._ahead_since is not None and tick - self._ahead_since < self._plan_wait:
            ahead = []
        if tick - self._changed_at >= self._repair_after:
            ahead = sorted(ahead + [n for n, its in others.items() if its.epoch == epoch and its.robot_type])
        if ahead:
            # Another neighbor each time: one that cannot help must not be asked forever.
            neighbor = ahead[(tick // self._repair_period + self._robot) % len(ahead)]
            mesh.send(neighbor, encode_body(RowRequest(self.book.epoch, self.book.versions())))
            self._asked_at = tick
            self._repair_pause = min(2 * self._repair_pause, REPAIR_PAUSES_MAX * self._repair_period)

    def _take(self, tick: int, row: CostRow) -> None:
        """Merge a row that somebody has sent.

        One of this robot's own is from an earlier life of it, or forged; its next offer outbids it. Such rows may lead
        the count of its offers by as much as others accept at once, no more: each step that a forger leads the robot on
        would use up versions.
        """
        if row.robot == self._robot and row.version > self._offered + VERSION_LEAP_MAX:
            return
        held = self.book.version_of(self._robot)
        changed = self.book.put(row)
        if row.robot == self._robot and row.version >= held and checksum(row) != self._sent:
            self.is_contested |= changed or row.version == held
        self._note(tick, changed=changed)

    def _completed(self, plan: Plan) -> Plan:
        """Return a plan with the goals that it leaves to be found; without any if there are none to be found.

        Its place in the book is the plan's all the same: the mission computer and the neighbors have it too. What is
        handed on does not hold the goals.
        """
        try:
            whole = completed(plan, self._partition)
        except ShapeError as error:
            _log.warning("%s finds no goals for plan %d: %s", robot_name(self._robot), plan.epoch, error)
            return plan
        if plan.task is Task.PARTITION and goals_crc(whole.goals, whole.goal_types) != plan.goals_crc:
            _log.warning(
                "%s finds other goals for plan %d than the mission computer; give both the same settings and software",
                robot_name(self._robot),
                plan.epoch,
            )
        return whole

    def _hand_on(self, tick: int, asking: Sequence[NodeId], mesh: Network) -> None:
        """Give the plan to who has asked for it, but not to somebody who has just been given it: it is on its way.

        Where two parts of a network meet, all of the one part may ask the first robot of it that has the plan of the
        other.
        """
        plan, pause = self.book.plan, HAND_ON_PAUSES * self._repair_period
        since = [max(self._handed_on.get(node, -pause), self._handed_on.get(EVERYONE, -pause)) for node in asking]
        new = [node for node, given in zip(asking, since, strict=True) if tick - given >= pause]
        if plan is None or not new:
            return
        body = encode_body(plan)
        if len(new) >= CROWD:
            mesh.flood(body)
            self._handed_on[EVERYONE] = tick
            return
        for node in new:
            mesh.send(node, body)
            self._handed_on[node] = tick

    def _answer(self, tick: int, asker: NodeId, request: RowRequest, mesh: Network) -> None:
        if self.book.plan is None or request.epoch > self.book.epoch:
            return
        held = request.held if request.epoch == self.book.epoch else ()
        rows = self.book.missing_in(held) or self._disputed_with(mesh.neighbors.get(asker), held)
        # Begin elsewhere each time: rows that the asker cannot take must not keep the others from it.
        first = tick % len(rows) if sum(map(row_size, rows)) > BUNDLE_SIZE * BUNDLES_PER_REQUEST else 0
        bundles = islice(_bundled(rows[first:] + rows[:first]), min(BUNDLES_PER_REQUEST, self._bundles_left))
        for bundle in bundles:
            self._bundles_left -= 1
            mesh.send(asker, encode_body(bundle))

    def _disputed_with(self, asker: Presence | None, held: Sequence[tuple[NodeId, int]]) -> tuple[CostRow, ...]:
        """Return all rows if a neighbor has some that are not these, though they have the same versions."""
        book = self.book
        is_other = asker is not None and asker.epoch == book.epoch and asker.digest != book.digest
        return book.all_rows() if is_other and tuple(held) == book.versions() else ()

    def _note(self, tick: int, *, changed: bool) -> None:
        if changed:
            self._changed_at = tick
            self._repair_pause = self._repair_period


def _bundled(rows: Sequence[CostRow]) -> Iterator[RowBundle]:
    """Yield the rows in bundles of at most `BUNDLE_SIZE` bytes, or of one row that is longer."""
    some: list[CostRow] = []
    size = 0
    for row in rows:
        if some and size + row_size(row) > BUNDLE_SIZE:
            yield RowBundle(tuple(some))
            some, size = [], 0
        some.append(row)
        size += row_size(row)
    if some:
        yield RowBundle(tuple(some))
