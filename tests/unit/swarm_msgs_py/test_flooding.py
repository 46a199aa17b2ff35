from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from mesh_lab import MeshLab
from oracles import hop_counts

from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.radio import Packet
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.flooding import FloodQueue, RelayPolicy, Vicinity, must_relay, policy_against
from swarm_msgs_py.types import EVERYONE, NodeId

ME, ORIGIN = NodeId(0), NodeId(9)
SETTLED = 12
ONE_COPY = RelayPolicy(1)


def make_packet(number: int = 1, origin: NodeId = ORIGIN) -> Packet:
    return Packet(origin, 0, EVERYONE, origin, EVERYONE, number, 5, b"")


def make_vicinity(neighbors: Iterable[int], links: Iterable[tuple[int, int]] = (), node: NodeId = ME) -> Vicinity:
    """Return what `node` knows: its neighbors, and which of them hear each other."""
    ids = np.array(sorted(neighbors), dtype=np.int64)
    hears = np.eye(len(ids), dtype=np.bool_)
    for a, b in links:
        row, column = np.searchsorted(ids, (a, b))
        hears[row, column] = hears[column, row] = True
    return Vicinity(node, ids, hears)


def test_a_neighbor_that_nobody_else_is_known_to_serve_is_served() -> None:
    assert must_relay(make_packet(), [NodeId(1)], make_vicinity([1, 2]), copies=1)


def test_a_neighbor_that_heard_the_transmitter_itself_needs_no_relay() -> None:
    assert not must_relay(make_packet(), [NodeId(1)], make_vicinity([1, 2], [(1, 2)]), copies=1)


def test_nobody_relays_to_the_transmitter_and_the_origin_alone() -> None:
    assert not must_relay(make_packet(), [NodeId(1)], make_vicinity([1, 9]), copies=3)


def test_every_copy_that_was_overheard_counts() -> None:
    vicinity = make_vicinity([1, 2, 3], [(1, 3), (2, 3)])

    assert must_relay(make_packet(), [NodeId(1)], vicinity, copies=2)
    assert not must_relay(make_packet(), [NodeId(1), NodeId(2)], vicinity, copies=2)


def test_exactly_one_of_two_holders_serves_a_common_neighbor_and_they_take_turns() -> None:
    """Radio 1 was heard by 0 and 2, which hear each other; 3 hears only these two."""
    turns = []
    for number in range(200):
        packet = make_packet(number)
        mine = must_relay(packet, [NodeId(1)], make_vicinity([1, 2, 3], [(1, 2), (2, 3)]), copies=1)
        others = make_vicinity([0, 1, 3], [(0, 1), (0, 3)], node=NodeId(2))
        assert mine != must_relay(packet, [NodeId(1)], others, copies=1)
        turns.append(mine)

    assert 60 < sum(turns) < 140


@pytest.mark.parametrize(
    ("loss", "redundancy", "delay", "policy"),
    [
        (0.0, 1, 0, RelayPolicy(2)),
        (0.03, 0, 3, RelayPolicy(1)),
        (0.1, 1, 0, RelayPolicy(2, 2, 2)),
        (0.1, 4, 0, RelayPolicy(5, 2, 2)),
        (0.3, 1, 1, RelayPolicy(4, 4, 4)),
        (1.0, 0, 0, RelayPolicy(7, 7, 2)),
    ],
)
def test_the_more_frames_are_lost_the_more_is_done_for_each(
    loss: float, redundancy: int, delay: int, policy: RelayPolicy
) -> None:
    assert policy_against(loss, redundancy, delay) == policy


def test_own_packets_go_first_and_without_question_then_the_oldest() -> None:
    queue = FloodQueue(8)
    first, second, own = make_packet(1), make_packet(2), make_packet(7, ME)
    queue.put(0, first, NodeId(1))
    queue.put(0, second, NodeId(1))
    queue.put_own(0, own)
    vicinity = make_vicinity([1, 2])

    assert [queue.next(0, vicinity, ONE_COPY) for _ in range(4)] == [own, first, second, None]


def test_a_plan_overtakes_everything_that_waits_at_every_radio_on_its_way() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]])
    plan = encode_body(Plan(7, square, (), square, np.array([1, 1, 1])))
    queue, vicinity = FloodQueue(8), make_vicinity([1, 2])
    queue.put_own(0, make_packet(1, ME))
    queue.put(0, make_packet(2), NodeId(1))
    queue.put(1, replace(make_packet(3), body=plan), NodeId(1))

    sent = [queue.next(9, vicinity, ONE_COPY) for _ in range(3)]

    assert [packet.number for packet in sent if packet is not None] == [3, 1, 2]


@pytest.mark.parametrize(("crowd", "relays"), [(3, True), (30, False)])
def test_a_plan_is_relayed_once_more_than_needed_unless_there_is_a_crowd(crowd: int, relays: bool) -> None:
    """All neighbors are said to have heard the transmitter, which may have been true a moment ago."""
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]])
    plan = encode_body(Plan(7, square, (), square, np.array([1, 1, 1])))
    names = range(1, crowd + 1)
    vicinity = make_vicinity(names, [(1, other) for other in names if other > 1])
    sent = {b"": 0, plan: 0}
    for body in sent:
        for number in range(20):  # radios take turns
            queue = FloodQueue(8)
            queue.put(0, replace(make_packet(number), body=body), NodeId(1))
            sent[body] += queue.next(9, vicinity, ONE_COPY) is not None

    assert sent[b""] == 0
    assert (sent[plan] > 0) == relays


def test_a_packet_that_others_have_relayed_while_it_waited_is_given_up() -> None:
    queue = FloodQueue(8)
    queue.put(0, make_packet(), NodeId(1))
    queue.overhear((ORIGIN, 1), NodeId(2))

    assert queue.next(0, make_vicinity([1, 2, 3], [(2, 3)]), ONE_COPY) is None
    assert len(queue) == 0


def test_the_queue_is_bounded_and_drops_the_oldest() -> None:
    queue = FloodQueue(4)
    for number in range(10):
        queue.put(0, make_packet(number), NodeId(1))
        queue.put_own(0, make_packet(number, ME))

    assert len(queue) == 8
    assert queue.dropped == 12
    packets = [queue.next(0, make_vicinity([1, 2]), ONE_COPY) for _ in range(9)]
    assert [packet.number for packet in packets if packet] == [6, 7, 8, 9] * 2


def sending_ticks(queue: FloodQueue, vicinity: Vicinity, policy: RelayPolicy, ticks: Iterable[int]) -> list[int]:
    return [tick for tick in ticks if queue.next(tick, vicinity, policy) is not None]


def test_where_frames_are_lost_a_bridge_repeats_a_packet_until_it_hears_that_it_went_on() -> None:
    policy, vicinity = RelayPolicy(copies=4, repeats=4, answer_ticks=3), make_vicinity([1, 2])
    queue = FloodQueue(8)
    queue.put(0, make_packet(), NodeId(1))

    unanswered = sending_ticks(queue, vicinity, policy, range(5))
    queue.overhear((ORIGIN, 1), NodeId(2))
    answered = sending_ticks(queue, vicinity, policy, range(5, 20))

    assert (unanswered, answered) == ([0, 3], [])
    assert len(queue) == 0


def test_nothing_is_repeated_more_often_than_the_loss_calls_for() -> None:
    policy, vicinity = RelayPolicy(copies=4, repeats=3, answer_ticks=2), make_vicinity([1, 2])
    queue = FloodQueue(8)
    queue.put_own(0, make_packet(7, ME))

    assert sending_ticks(queue, vicinity, policy, range(20)) == [0, 2, 4]
    assert len(queue) == 0


def test_neighbors_that_had_all_copies_already_cause_no_repetition() -> None:
    policy = RelayPolicy(copies=2, repeats=2, answer_ticks=2)
    queue = FloodQueue(8)
    vicinity = make_vicinity([1, 2, 3], [(2, 3)])
    queue.put(0, make_packet(), NodeId(1))

    first = sending_ticks(queue, vicinity, policy, range(1))
    queue.overhear((ORIGIN, 1), NodeId(3))

    assert first == [0]
    assert sending_ticks(queue, vicinity, policy, range(1, 20)) == []


def test_of_many_who_hold_a_long_packet_only_as_many_relay_at_once_as_the_channel_has_room_for() -> None:
    """Radios 1 to 20 heard 50, hear each other, and each has a neighbor 100 + n of its own that must be served."""
    holders = range(1, 21)
    packet = Packet(ORIGIN, 0, EVERYONE, ORIGIN, EVERYONE, 1, 5, bytes(1000))
    links = [(a, b) for b in (*holders, 50) for a in holders if a < b]
    turns = []
    for holder in holders:
        queue = FloodQueue(4)
        queue.put(7, packet, NodeId(50))
        others = [other for other in (*holders, 50) if other != holder]
        vicinity = make_vicinity(
            [*others, 100 + holder], [pair for pair in links if holder not in pair], NodeId(holder)
        )
        turns.append(next(tick for tick in range(7, 20) if queue.next(tick, vicinity, ONE_COPY, room=4000.0)))

    assert sorted(turns) == [7] * 4 + [8] * 4 + [9] * 4 + [10] * 4 + [11] * 4


def grid(side: int) -> list[tuple[int, int]]:
    """Return the links of a square grid with diagonals over two steps: about twenty neighbors for each radio."""
    points = [(i, j) for i in range(side) for j in range(side)]
    return [
        (a, b)
        for b in range(len(points))
        for a in range(b)
        if max(abs(points[a][0] - points[b][0]), abs(points[a][1] - points[b][1])) <= 2
    ]


def test_in_a_dense_mesh_most_radios_stay_silent_and_everybody_hears_every_flood() -> None:
    links = grid(6)
    lab = MeshLab(36, links, config=NetworkConfig(flood_redundancy=0, paced_bps=1e9))
    lab.run(SETTLED)
    before = sum(node.counters.frames_sent for node in lab.nodes.values())

    for _ in range(10):
        lab.receive()
        lab.nodes[0].flood(b"x")
        lab.transmit()
    lab.run(12)

    floods = sum(node.counters.frames_sent for node in lab.nodes.values()) - before - 22 * 36
    assert {node: len(deliveries) for node, deliveries in lab.deliveries.items()} == dict.fromkeys(range(1, 36), 10)
    assert floods <= 10 * 36 / 2


def test_floods_cross_a_chain_of_single_links_although_a_fifth_of_all_frames_is_lost() -> None:
    chain = [(k, k + 1) for k in range(7)]
    lab = MeshLab(8, chain, seed=3, loss=0.2, config=NetworkConfig(missed_adverts=10))
    lab.run(4 * SETTLED)

    for _ in range(40):
        lab.receive()
        lab.nodes[0].flood(b"x")
        lab.transmit()
    lab.run(40)

    assert len(lab.deliveries[7]) >= 32  # one transmission each: 0.8 ** 7 of 40, about 8


def test_floods_reach_nearly_everybody_although_a_third_of_all_frames_is_lost() -> None:
    lab = MeshLab(36, grid(6), seed=5, loss=0.3, config=NetworkConfig(paced_bps=1e9))
    lab.run(SETTLED)

    for _ in range(20):
        lab.receive()
        lab.nodes[0].flood(b"x")
        lab.transmit()
    lab.run(12)

    assert sum(map(len, lab.deliveries.values())) >= 0.99 * 20 * 35


def test_a_crowd_that_floods_at_once_keeps_to_its_share_of_the_channel_and_gets_everything_through() -> None:
    """Twenty radios that all hear each other flood 20 packets of 500 bytes each: 1.6 Mbit for one copy."""
    radios, paced, body = 20, 100_000.0, bytes(500)
    links = [(a, b) for b in range(radios) for a in range(b)]
    lab = MeshLab(radios, links, config=NetworkConfig(flood_redundancy=0, paced_bps=paced))
    lab.run(SETTLED)
    assert set(hop_counts(links, 0).values()) == {0, 1}

    lab.receive()
    for node in lab.nodes.values():
        for _ in range(20):
            node.flood(body)
    loads = []
    for _ in range(60):
        before = sum(node.counters.bytes_sent for node in lab.nodes.values())
        lab.transmit()
        hellos = 250 * radios  # at most: a full dump
        loads.append(sum(node.counters.bytes_sent for node in lab.nodes.values()) - before - hellos)
        lab.receive()

    assert max(loads[k] + loads[k + 1] for k in range(59)) <= paced / 8 + radios * 600
    assert all(len(lab.deliveries[node]) == 19 * 20 for node in range(radios))


def test_what_has_waited_for_too_long_is_dropped() -> None:
    queue = FloodQueue(4, stay_ticks_max=5)
    queue.put_own(0, make_packet(1))
    vicinity = Vicinity(NodeId(0), np.zeros(0, dtype=np.int64), np.zeros((0, 0), dtype=np.bool_))

    assert queue.next(6, vicinity, RelayPolicy(1)) is None
    assert (len(queue), queue.dropped) == (0, 1)
