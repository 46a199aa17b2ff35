"""Rows that speak for the robot that hears them, of an earlier life of it or forged; and rows by the thousand."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.rows import ROWS_MAX
from swarm_msgs_py.body_codec import BODY_MAX, decode_body, encode_body
from swarm_msgs_py.messages.bodies import VERSION_LEAP_MAX, CostRow, Plan, RowBundle, RowRequest
from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId

PERIOD = 0.5
SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])


def make_plan(goals: int, epoch: int = 1) -> Plan:
    return Plan(epoch, SQUARE, (), np.zeros((goals, 2)), np.ones(goals, dtype=np.int64))


def make_row(robot: int, goals: int, version: int = 1, epoch: int = 1) -> CostRow:
    return CostRow(epoch, NodeId(robot), 1, version, np.full(goals, robot))


class Recorder(MeshNetwork):
    """A mesh that only notes what it is to flood."""

    def __init__(self) -> None:
        super().__init__(NodeId(0), NetworkConfig(), PERIOD)
        self.flooded: list[bytes] = []

    def flood(self, body: bytes) -> None:
        self.flooded.append(body)


def make_mind(goals: int) -> Consensus:
    """Return what robot 0 knows when it has heard a plan."""
    mind = Consensus(NodeId(0), 1, DecisionConfig(), PERIOD)
    tell(mind, make_plan(goals))
    return mind


def tell(mind: Consensus, *records: Plan | CostRow | RowBundle) -> None:
    mind.receive(0, [Delivery(NodeId(9), encode_body(record)) for record in records], Recorder())


def offered(mind: Consensus) -> CostRow:
    """Offer costs; return the row that is flooded."""
    mesh = Recorder()
    mind.offer(0, np.array([1, 2]), mesh)
    (row,) = map(decode_body, mesh.flooded)
    assert isinstance(row, CostRow)
    return row


def test_a_row_of_an_earlier_life_is_taken_and_outbid() -> None:
    mind = make_mind(goals=2)
    tell(mind, make_row(0, 2, version=37))

    assert offered(mind).version == 38


@pytest.mark.parametrize("cost", [3, 4, 5, 6])
def test_another_row_under_the_number_of_the_last_one_sent_is_outbid_whichever_of_them_counts(cost: int) -> None:
    mind = make_mind(goals=2)
    sent = offered(mind)
    tell(mind, sent)
    assert not mind.is_contested

    tell(mind, CostRow(1, NodeId(0), 1, sent.version, np.array([cost, cost])))

    assert mind.is_contested
    assert offered(mind).version == sent.version + 1
    tell(mind, sent)  # late
    assert not mind.is_contested


@pytest.mark.parametrize("bundled", [False, True])
def test_forged_rows_cannot_lead_a_robot_to_the_end_of_its_versions(bundled: bool) -> None:
    mind = make_mind(goals=2)
    for version in range(1000, 65535, 1000):
        row = make_row(0, 2, version=version)
        tell(mind, RowBundle((row,)) if bundled else row)
        own = offered(mind)

    assert mind.book.version_of(NodeId(0)) == own.version < VERSION_LEAP_MAX + 70


def test_the_lead_that_forged_rows_have_won_ends_with_the_plan() -> None:
    mind = make_mind(goals=2)
    tell(mind, make_row(0, 2, version=VERSION_LEAP_MAX))
    tell(mind, make_plan(2, epoch=2))

    assert offered(mind).version == 1
    tell(mind, make_row(0, 2, epoch=2, version=VERSION_LEAP_MAX + 2))
    assert mind.book.version_of(NodeId(0)) == 1


def test_a_robot_whose_versions_are_used_up_keeps_its_last_row() -> None:
    mind = make_mind(goals=2)
    for version in (*range(1000, 65535, 1000), 65535):
        mind.book.put(make_row(0, 2, version=version))
    mesh = Recorder()

    mind.offer(0, np.array([1, 2]), mesh)

    assert mesh.flooded == []
    assert mind.book.version_of(NodeId(0)) == 65535


def test_rows_of_more_robots_than_there_can_be_are_not_kept() -> None:
    mind = make_mind(goals=1)
    crowd = [CostRow(1, NodeId(robot), 1, 1, np.empty(0, dtype=np.int64)) for robot in range(ROWS_MAX + 500)]
    for first in range(0, len(crowd), 4500):
        tell(mind, RowBundle(tuple(crowd[first : first + 4500])))

    assert len(mind.book) == ROWS_MAX
    tell(mind, make_row(7, 1, version=2))  # of one that is known
    assert mind.book.version_of(NodeId(7)) == 2
    assert len(encode_body(RowRequest(1, mind.book.versions()))) <= BODY_MAX
