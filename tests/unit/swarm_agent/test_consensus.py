"""Plan and cost rows spread over a lossy, multi-hop, sometimes split radio network, until all hold the same."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from builders import make_presence
from rows_room import PERIOD, Room, make_plan

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import BUNDLE_SIZE, BUNDLES_PER_REQUEST, BUNDLES_PER_TICK, Consensus
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.messages.bodies import EPOCH_LEAP_MAX, VERSION_LEAP_MAX, CostRow, Plan, RowBundle, RowRequest
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId

REST = np.zeros(2)
SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
CHAIN = [(i, i + 1) for i in range(7)]


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
    room.run(20.0)  # each of four robots waits for the plan before it asks for it

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


def make_row(robot: int, goals: int, version: int = 1, epoch: int = 1) -> CostRow:
    return CostRow(epoch, NodeId(robot), 1, version, np.full(goals, robot))


def presence(epoch: int) -> Presence:
    return make_presence(mode=int(Mode.UNASSIGNED), epoch=epoch)


class Recorder(MeshNetwork):
    """A mesh with a route to everybody that only notes what it is to carry."""

    def __init__(self) -> None:
        super().__init__(NodeId(0), NetworkConfig(), PERIOD)
        self.carried: list[tuple[NodeId, bytes]] = []
        self.heard: dict[NodeId, Presence] = {}

    @property
    def neighbors(self) -> dict[NodeId, Presence]:
        return self.heard or super().neighbors

    def send(self, destination: NodeId, body: bytes) -> bool:
        self.carried.append((destination, body))
        return True


def answers(mind: Consensus, tick: int, *requests: RowRequest) -> list[tuple[NodeId, bytes]]:
    """Return the packets, asker and body, that answer the requests of robots 1, 2, ... in one tick."""
    mesh = Recorder()
    mind.receive(tick, [Delivery(NodeId(k), encode_body(r)) for k, r in enumerate(requests, start=1)], mesh)
    return mesh.carried


def make_mind(rows: int, goals: int) -> Consensus:
    mind = Consensus(NodeId(0), 1, DecisionConfig(), PERIOD)
    tell(mind, make_plan(goals), *(make_row(robot, goals) for robot in range(rows)))
    return mind


def tell(mind: Consensus, *records: Plan | CostRow | RowBundle) -> None:
    mind.receive(0, [Delivery(NodeId(9), encode_body(record)) for record in records], Recorder())


def rows_of(bodies: Iterable[bytes]) -> list[int]:
    bundles = [body for body in map(decode_body, bodies) if isinstance(body, RowBundle)]
    return [row.robot for bundle in bundles for row in bundle.rows]


def test_rows_are_answered_in_packets_of_bounded_size_and_number() -> None:
    mind = make_mind(rows=500, goals=150)  # 155 KB of rows: more than a frame can carry

    bodies = [body for _, body in answers(mind, 1, RowRequest(1, ()))]

    assert len(bodies) == BUNDLES_PER_REQUEST
    assert all(len(body) <= BUNDLE_SIZE + 3 for body in bodies)
    assert len(set(rows_of(bodies))) == 3 * BUNDLES_PER_REQUEST


def test_a_row_longer_than_a_packet_of_rows_travels_alone() -> None:
    mind = make_mind(rows=3, goals=1000)

    bodies = [body for _, body in answers(mind, 0, RowRequest(1, ()))]

    assert rows_of(bodies) == [0, 1, 2]
    assert len(bodies) == 3


def test_all_requests_of_a_tick_together_are_answered_with_a_bounded_number_of_packets() -> None:
    mind = make_mind(rows=500, goals=150)

    carried = answers(mind, 1, *[RowRequest(1, ())] * 5)
    again = answers(mind, 2, RowRequest(1, ()))

    assert len(carried) == BUNDLES_PER_TICK
    assert {asker for asker, _ in carried} == {1, 2}
    assert len(again) == BUNDLES_PER_REQUEST


def test_who_keeps_asking_gets_every_row_even_behind_rows_that_it_cannot_take() -> None:
    mind = make_mind(rows=300, goals=150)
    got: set[int] = set()
    for tick in range(0, 400, 3):
        # Rows below 100 are refused by the asker each time; the others it holds from then on.
        held = tuple((NodeId(robot), 1) for robot in sorted(got) if robot >= 100)
        got |= set(rows_of(body for _, body in answers(mind, tick, RowRequest(1, held))))

    assert got == set(range(300))


def test_a_large_swarm_is_repaired_in_several_requests() -> None:
    room = Room(2, [(0, 1)])
    plan = make_plan(150)
    for robot in range(2):
        room.hand_over(robot, plan)
    rows = [Delivery(NodeId(9), encode_body(make_row(robot, 150))) for robot in range(2, 150)]
    room.minds[0].receive(0, rows, Recorder())

    room.run(40.0)

    assert room.rows == [150, 150]
    assert len(room.digests) == 1


@pytest.mark.parametrize("epoch", [0, EPOCH_LEAP_MAX + 2, 2**31, 2**32 - 1])
def test_a_plan_with_an_absurd_number_is_ignored_and_does_not_shut_out_the_next(epoch: int) -> None:
    mind = make_mind(rows=2, goals=2)

    tell(mind, make_plan(2, epoch))
    assert (mind.book.epoch, len(mind.book)) == (1, 2)
    tell(mind, make_plan(2, 2))

    assert mind.book.epoch == 2


@pytest.mark.parametrize(
    "plan",
    [
        Plan(2, SQUARE, (), np.zeros((0, 2)), np.zeros(0, dtype=np.int64)),
        Plan(2, SQUARE, (SQUARE, np.zeros((0, 2))), np.zeros((1, 2)), np.ones(1, dtype=np.int64)),
    ],
    ids=["no goals", "an obstacle without corners"],
)
def test_a_plan_that_nobody_can_follow_is_ignored(plan: Plan) -> None:
    mind = make_mind(rows=2, goals=2)

    tell(mind, plan)

    assert mind.book.epoch == 1


def test_an_absurd_version_does_not_shut_out_a_robot_s_real_rows() -> None:
    mind = make_mind(rows=2, goals=2)

    tell(mind, RowBundle((make_row(1, 2, version=VERSION_LEAP_MAX + 2), make_row(1, 2, version=65535))))
    assert mind.book.version_of(NodeId(1)) == 1
    tell(mind, make_row(1, 2, version=2))

    assert mind.book.version_of(NodeId(1)) == 2


def test_rows_without_a_plan_are_ignored() -> None:
    mind = Consensus(NodeId(0), 1, DecisionConfig(), PERIOD)

    tell(mind, make_row(1, 0, epoch=0), make_row(1, 2))

    assert (len(mind.book), mind.book.digest) == (0, 0)


def test_nobody_is_asked_for_a_plan_with_an_absurd_number() -> None:
    mind, mesh = make_mind(rows=2, goals=2), Recorder()
    boaster = MeshNetwork(NodeId(1), NetworkConfig(), PERIOD)
    mesh.receive(20, boaster.transmit(0, presence(2**32 - 1)))
    mesh.receive(30, boaster.transmit(0, presence(2**32 - 1)))

    mind.repair(30, mesh)
    assert mesh.carried == []
    mesh.receive(31, boaster.transmit(0, presence(2)))
    mind.repair(31, mesh)
    mind.repair(31 + round(DecisionConfig().plan_wait_s / PERIOD), mesh)

    assert [asked for asked, _ in mesh.carried] == [1]


def kinds_of(packets: list[tuple[NodeId, bytes]]) -> list[tuple[NodeId, str]]:
    return [(asker, type(decode_body(body)).__name__) for asker, body in packets]


def test_a_plan_goes_to_each_of_few_who_ask_and_not_again_while_it_is_on_its_way() -> None:
    mind = make_mind(rows=0, goals=2)

    first = answers(mind, 1, RowRequest(0, ()), RowRequest(0, ()))
    again = answers(mind, 3, RowRequest(0, ()), RowRequest(0, ()))
    later = answers(mind, 40, RowRequest(0, ()))

    assert kinds_of(first) == [(1, "Plan"), (2, "Plan")]
    assert again == []
    assert kinds_of(later) == [(1, "Plan")]


def test_a_crowd_that_asks_for_the_plan_is_served_by_one_flood(monkeypatch: pytest.MonkeyPatch) -> None:
    floods: list[bytes] = []
    monkeypatch.setattr(Recorder, "flood", lambda _, body: floods.append(body))
    mind = make_mind(rows=0, goals=2)

    carried = answers(mind, 1, *[RowRequest(0, ())] * 12)
    answers(mind, 2, *[RowRequest(0, ())] * 12)

    assert carried == []
    assert floods == [encode_body(make_plan(2))]


def test_who_asks_without_effect_asks_less_often_until_something_comes() -> None:
    mind, mesh = make_mind(rows=1, goals=2), Recorder()
    neighbor = MeshNetwork(NodeId(1), NetworkConfig(), PERIOD)

    def ask(first: int, ticks: int) -> list[int]:
        asked = []
        for tick in range(first, first + ticks):
            mesh.receive(tick, neighbor.transmit(tick, presence(1)))
            mesh.carried.clear()
            mind.repair(tick, mesh)
            asked += [tick] * len(mesh.carried)
        return asked

    pauses = np.diff(ask(20, 60))
    mind.receive(80, [Delivery(NodeId(1), encode_body(make_row(1, 2)))], mesh)
    after = np.diff(ask(81, 12))

    assert pauses[0] < pauses[1] == pauses[-1]
    assert after[0] == pauses[0]


def test_a_newer_plan_is_asked_for_only_when_its_flood_has_had_time_to_come() -> None:
    mind, mesh = make_mind(rows=2, goals=2), Recorder()
    neighbor = MeshNetwork(NodeId(1), NetworkConfig(), PERIOD)
    asked: list[int] = []
    for tick in range(16):
        mesh.receive(tick, neighbor.transmit(tick, make_presence(epoch=1 if tick < 8 else 2, tick=tick)))
        mesh.carried.clear()
        mind.repair(tick, mesh)
        asked += [tick] * sum(body == encode_body(RowRequest(1, mind.book.versions())) for _, body in mesh.carried)

    first = next(tick for tick in asked if tick >= 8)
    assert 8 + round(DecisionConfig().plan_wait_s / PERIOD) <= first <= 14


@pytest.mark.parametrize("cost", [7, 8, 9, 10])
def test_after_a_restart_all_hold_the_same_rows_though_two_of_them_had_one_number(cost: int) -> None:
    room = Room(8, CHAIN)
    room.hand_over(0, make_plan(8))
    room.run(20.0)
    links = room.links
    room.links = {(a, b) for a, b in links if 3 not in {a, b}}  # so that its flood reaches nobody
    room.restart(3, cost)
    room.hand_over(3, make_plan(8))
    room.run(10.0)
    assert {mind.book.version_of(NodeId(3)) for mind in room.minds} == {1}
    assert len(room.digests) == 2

    room.links = links
    room.run(60.0)

    assert len(room.digests) == 1
    assert len({row.costs[0] for mind in room.minds for row in mind.book.all_rows() if row.robot == 3}) == 1


@pytest.mark.parametrize(("shown", "is_told"), [("the same digest", False), ("another digest", True)])
def test_who_holds_the_same_versions_is_told_all_rows_only_if_they_say_something_else(
    shown: str, is_told: bool
) -> None:
    room = Room(2, [(0, 1)])
    room.hand_over(0, make_plan(2))
    room.run(10.0)
    mind, mesh = room.minds[0], Recorder()
    digest = mind.book.digest + (shown == "another digest")
    mesh.heard = {NodeId(1): make_presence(tick=29, mode=int(Mode.UNASSIGNED), epoch=1, digest=digest)}
    request = RowRequest(1, room.minds[1].book.versions())

    mind.receive(30, [Delivery(NodeId(1), encode_body(request))], mesh)

    bundles = [decode_body(body) for _, body in mesh.carried]
    assert [len(bundle.rows) for bundle in bundles if isinstance(bundle, RowBundle)] == [2] * is_told
