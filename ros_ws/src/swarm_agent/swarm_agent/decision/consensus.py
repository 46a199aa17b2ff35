"""How all robots come to hold the same plan and the same cost rows, over a radio that loses frames.

Two mechanisms: a *flood* brings every record to everyone once, fast; *anti-entropy* repairs what the flood lost. Every
hello carries the epoch and a digest of the rows held. A robot whose own rows have been at rest for a while, and whose
neighbor still shows another digest, asks that neighbor for what it lacks. Records merge in any order, so the swarm ends
at one common set wherever it is connected, also after a partition has healed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.rows import RowBook
from swarm_msgs_py.body_codec import decode_body, encode_body, row_size
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.bodies import CostRow, Plan, RowBundle, RowRequest, is_newer_epoch
from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import IntArray, NodeId

BUNDLE_SIZE = 1000
"""Bytes of cost rows in one packet (at least one row): about what a radio sends in a few hundredths of a second."""

BUNDLES_PER_REQUEST, BUNDLES_PER_TICK = 8, 16
"""Packets of rows that answer one request, and all requests of one tick; what is left waits for the next request."""


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
    """

    def __init__(self, robot: NodeId, robot_type: int, config: DecisionConfig, period_s: float) -> None:
        self._robot = robot
        self._robot_type = robot_type
        self._repair_after = max(1, round(config.repair_after_s / period_s))
        self._repair_period = max(1, round(config.repair_period_s / period_s))
        self._changed_at = 0  # tick of the last change of the book
        self._asked_at = -self._repair_period
        self._bundles_left = BUNDLES_PER_TICK
        self.book = RowBook()

    @property
    def plan(self) -> Plan | None:
        """The newest plan heard."""
        return self.book.plan

    def receive(self, tick: int, deliveries: Sequence[Delivery], mesh: MeshNetwork) -> None:
        """Merge what the mesh delivered; answer requests of neighbors."""
        self._bundles_left = BUNDLES_PER_TICK
        for delivery in deliveries:
            try:
                body = decode_body(delivery.body)
            except FrameError:
                continue  # a newer software's record, or damage that the frame's checksum missed
            if isinstance(body, Plan):
                self._note(tick, changed=self.book.adopt(body))
            elif isinstance(body, CostRow):
                self._note(tick, changed=self.book.put(body))
            elif isinstance(body, RowBundle):
                for row in body.rows:
                    self._note(tick, changed=self.book.put(row))
            elif isinstance(body, RowRequest):
                self._answer(tick, delivery.origin, body, mesh)

    def offer(self, tick: int, costs: IntArray, mesh: MeshNetwork) -> None:
        """Publish this robot's own costs [cm] for the plan in force."""
        version = self.book.version_of(self._robot) + 1
        row = CostRow(self.book.epoch, self._robot, self._robot_type, version, costs)
        self._note(tick, changed=self.book.put(row))
        mesh.flood(encode_body(row))

    def repair(self, tick: int, mesh: MeshNetwork) -> None:
        """Ask one neighbor for what it holds and this robot lacks, if there is such a neighbor."""
        if tick - self._asked_at < self._repair_period:
            return
        at_rest = tick - self._changed_at >= self._repair_after
        epoch, digest = self.book.epoch, self.book.digest
        ahead = [
            neighbor
            for neighbor, its in mesh.neighbors.items()
            if its.digest != digest or its.epoch != epoch
            if is_newer_epoch(its.epoch, epoch) or (at_rest and its.epoch == epoch and its.robot_type)
        ]
        if ahead:
            # Another neighbor each time: one that cannot help must not be asked forever.
            neighbor = ahead[(tick // self._repair_period + self._robot) % len(ahead)]
            mesh.send(neighbor, encode_body(RowRequest(self.book.epoch, self.book.versions())))
            self._asked_at = tick

    def _answer(self, tick: int, asker: NodeId, request: RowRequest, mesh: MeshNetwork) -> None:
        if self.book.plan is None or request.epoch > self.book.epoch:
            return
        if request.epoch < self.book.epoch:
            mesh.send(asker, encode_body(self.book.plan))
        held = request.held if request.epoch == self.book.epoch else ()
        rows = self.book.missing_in(held)
        # Begin elsewhere each time: rows that the asker cannot take must not keep the others from it.
        first = tick % len(rows) if sum(map(row_size, rows)) > BUNDLE_SIZE * BUNDLES_PER_REQUEST else 0
        bundles = islice(_bundled(rows[first:] + rows[:first]), min(BUNDLES_PER_REQUEST, self._bundles_left))
        for bundle in bundles:
            self._bundles_left -= 1
            mesh.send(asker, encode_body(bundle))

    def _note(self, tick: int, *, changed: bool) -> None:
        if changed:
            self._changed_at = tick


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
