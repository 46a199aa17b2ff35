"""Robots in one room that do nothing but come to know the same plan and the same rows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from builders import make_presence

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId

PERIOD = 0.5
SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])


def make_plan(robots: int, epoch: int = 1) -> Plan:
    return Plan(epoch, SQUARE, (), np.zeros((robots, 2)), np.ones(robots, dtype=np.int64))


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
        self.costs = [100 + i for i in range(robots)]  # that each robot offers [cm]

    def restart(self, robot: int, cost: int) -> None:
        """Let the software of one robot begin anew, which offers another row."""
        self._meshes[robot] = MeshNetwork(NodeId(robot), NetworkConfig(), PERIOD)
        self.minds[robot] = Consensus(NodeId(robot), 1, DecisionConfig(), PERIOD)
        self._offered[robot], self.costs[robot] = 0, cost

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
            mind.offer(self._tick, np.full(goals, self.costs[i]), mesh)
        book = mind.book
        presence = make_presence(tick=self._tick, mode=int(Mode.UNASSIGNED), epoch=book.epoch, digest=book.digest)
        return mesh.transmit(self._tick, presence)

    @property
    def rows(self) -> list[int]:
        return [len(mind.book) for mind in self.minds]

    @property
    def digests(self) -> set[int]:
        return {mind.book.digest for mind in self.minds}
