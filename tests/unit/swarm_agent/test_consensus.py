"""Plan and cost rows spread over a lossy, multi-hop, sometimes split radio network, until all hold the same."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId

PERIOD = 0.5
REST = np.zeros(2)
CHAIN = [(i, i + 1) for i in range(7)]


def make_plan(robots: int, epoch: int = 1) -> Plan:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    return Plan(epoch, square, (), np.zeros((robots, 2)), np.ones(robots, dtype=np.int64))


class Room:
    """Robots that do nothing but come to know the same, over given links."""

    def __init__(self, robots: int, links: Iterable[tuple[int, int]], loss: float = 0.0) -> None:
        self.links = set(links)
        self._loss = loss
        self._rng = np.random.default_rng(7)
        self._tick = 0
        self._meshes = [MeshNetwork(NodeId(i), NetworkConfig(), PERIOD) for i in range(robots)]
        self._air: list[list[bytes]] = [[] for _ in range(robots)]
        self._offered = [0] * robots
        self.minds = [Consensus(NodeId(i), 1, DecisionConfig(), PERIOD) for i in range(robots)]

    def hand_over(self, robot: int, plan: Plan) -> None:
        """Let one robot know the plan, as if the mission computer stood beside it, and flood it."""
        body = encode_body(plan)
        self.minds[robot].receive(self._tick, [Delivery(NodeId(robot), body)], self._meshes[robot])
        self._meshes[robot].flood(body)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD)):
            sent = [self._step(i, tuple(frames)) for i, frames in enumerate(self._air)]
            self._air = [[] for _ in sent]
            for a, b in sorted(self.links):
                for sender, receiver in ((a, b), (b, a)):
                    self._air[receiver] += [f for f in sent[sender] if self._rng.random() >= self._loss]
            self._tick += 1

    def _step(self, i: int, frames: tuple[bytes, ...]) -> tuple[bytes, ...]:
        mind, mesh = self.minds[i], self._meshes[i]
        mind.receive(self._tick, mesh.receive(self._tick, frames), mesh)
        mind.repair(self._tick, mesh)
        if mind.book.epoch > self._offered[i]:
            self._offered[i] = mind.book.epoch
            goals = len(mind.book.plan.goals) if mind.book.plan else 0
            mind.offer(self._tick, np.full(goals, 100 + i), mesh)
        book = mind.book
        return mesh.transmit(
            self._tick, Presence(REST, REST, 0.1, 1, True, int(Mode.UNASSIGNED), book.epoch, book.digest)
        )

    @property
    def rows(self) -> list[int]:
        return [len(mind.book) for mind in self.minds]

    @property
    def digests(self) -> set[int]:
        return {mind.book.digest for mind in self.minds}


def test_a_flood_brings_plan_and_rows_to_the_end_of_a_chain() -> None:
    room = Room(8, CHAIN)
    room.hand_over(0, make_plan(8))

    room.run(9.0)  # seven hops there, seven back, one tick each, and the tick of the answer

    assert room.rows == [8] * 8
    assert len(room.digests) == 1


@pytest.mark.parametrize("loss", [0.1, 0.3, 0.5])
def test_what_the_flood_loses_is_repaired(loss: float) -> None:
    room = Room(8, [*CHAIN, (0, 2), (2, 4), (4, 6)], loss)
    room.hand_over(0, make_plan(8))

    room.run(60.0)

    assert room.rows == [8] * 8
    assert len(room.digests) == 1


def test_a_partition_heals() -> None:
    bridge = (3, 4)
    room = Room(8, [link for link in CHAIN if link != bridge])
    room.hand_over(0, make_plan(8))
    room.run(20.0)
    assert room.rows == [4] * 4 + [0] * 4

    room.links.add(bridge)
    room.run(15.0)

    assert room.rows == [8] * 8
    assert len(room.digests) == 1


def test_two_halves_with_rows_of_their_own_merge_within_ten_seconds() -> None:
    bridge = (3, 4)
    room = Room(8, [link for link in CHAIN if link != bridge])
    plan = make_plan(8)
    room.hand_over(0, plan)
    room.hand_over(7, plan)
    room.run(20.0)
    assert room.rows == [4] * 8

    room.links.add(bridge)
    room.run(10.0)

    assert room.rows == [8] * 8
    assert len(room.digests) == 1


def test_a_newer_plan_replaces_the_old_one_everywhere() -> None:
    room = Room(8, CHAIN)
    room.hand_over(0, make_plan(8))
    room.run(12.0)

    room.hand_over(7, make_plan(8, epoch=2))
    room.run(12.0)

    assert {mind.book.epoch for mind in room.minds} == {2}
    assert room.rows == [8] * 8


def test_a_body_that_is_not_a_record_is_ignored() -> None:
    mind = Consensus(NodeId(0), 1, DecisionConfig(), PERIOD)
    mesh = MeshNetwork(NodeId(0), NetworkConfig(), PERIOD)

    mind.receive(0, [Delivery(NodeId(1), b"\xff\x00nonsense")], mesh)

    assert mind.plan is None
