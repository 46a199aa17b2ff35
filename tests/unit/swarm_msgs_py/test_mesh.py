from __future__ import annotations

import numpy as np
import pytest
from builders import make_presence
from mesh_lab import PERIOD_S, MeshLab
from oracles import hop_counts

from swarm_msgs_py.body_codec import BODY_MAX
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.radio import Acknowledgement, Delivery, Hello, Packet
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.labels import Route
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import EVERYONE, MISSION, NodeId

A, B, C, D = (NodeId(n) for n in range(4))
CHAIN = ((0, 1), (1, 2), (2, 3))
CLIQUE = tuple((i, j) for i in range(8) for j in range(i))
SETTLED = 12
"""Ticks after which a static mesh of these sizes has long converged."""


def delivered(lab: MeshLab) -> dict[int, list[Delivery]]:
    return {node: [delivery for _, delivery in arrived] for node, arrived in lab.deliveries.items()}


def test_chain_learns_every_route_one_hop_per_tick() -> None:
    lab = MeshLab(4, CHAIN)

    lab.run(4)

    assert lab.hops(A) == {0: 0, 1: 1, 2: 2, 3: 3}
    assert [lab.nodes[n].next_hops(D) for n in (A, B, C)] == [[B], [C], [D]]


def test_loss_of_the_last_node_of_a_chain_never_counts_to_infinity() -> None:
    """Spec 5.1: plain distance vectors would send packets for D back and forth between C and B, hop counts growing."""
    lab = MeshLab(4, CHAIN)
    lab.run(SETTLED)
    lab.leave(D)

    hops_to_d = []
    for _ in range(30):
        lab.run(1)
        routes = [lab.nodes[n].route(D) for n in (A, B, C)]
        hops_to_d.append([route.hops for route in routes if route and route.hops != 255])

    assert max(hops for tick in hops_to_d for hops in tick) == 3
    assert hops_to_d[:4] == [[3, 2, 1]] * 3 + [[3, 2]]  # C noticed after three missed hellos
    assert hops_to_d[4:] == [[3]] + [[]] * 25  # B a tick later, then A
    assert all(lab.nodes[n].route(D) is None for n in (A, B, C))  # and deleted when stale


def test_broken_link_is_routed_around_and_the_short_route_comes_back_with_it() -> None:
    ring = (*CHAIN, (0, 3))
    lab = MeshLab(4, ring)
    lab.run(SETTLED)
    assert lab.hops(A)[D] == 1

    lab.links.discard((0, 3))
    lab.run(12)
    assert lab.nodes[A].route(D) == Route(D, B, 3, lab.nodes[A].route(D).sequence)  # type: ignore[union-attr]

    lab.links.add((0, 3))
    lab.run(2)
    assert lab.hops(A)[D] == 1


def test_neighbors_tell_the_latest_presence() -> None:
    lab = MeshLab(3, CHAIN[:2])

    lab.run(2)

    assert {n: presence.position[0] for n, presence in lab.nodes[B].neighbors.items()} == {A: 0.0, C: 2.0}


def test_flood_reaches_everyone_once_and_not_its_origin() -> None:
    lab = MeshLab(4, (*CHAIN, (0, 2), (1, 3)))
    lab.run(SETTLED)

    lab.receive()
    lab.nodes[A].flood(b"plan")
    lab.transmit()
    lab.run(5)

    assert delivered(lab) == {n: [Delivery(A, b"plan")] for n in (B, C, D)}


def test_flood_reaches_everyone_before_anybody_knows_anybody() -> None:
    lab = MeshLab(4, CHAIN)

    lab.receive()
    lab.nodes[A].flood(b"plan")
    lab.transmit()
    lab.run(4)

    assert delivered(lab) == {n: [Delivery(A, b"plan")] for n in (B, C, D)}


@pytest.mark.parametrize("redundancy", [0, 2])
def test_where_everybody_hears_everybody_only_a_few_relay_a_flood(redundancy: int) -> None:
    lab = MeshLab(8, CLIQUE, config=NetworkConfig(flood_redundancy=redundancy))
    lab.run(SETTLED)
    before = sum(node.counters.frames_sent for node in lab.nodes.values())

    lab.receive()
    lab.nodes[A].flood(b"plan")
    lab.transmit()
    lab.run(3)

    hellos = 4 * len(lab.nodes)
    assert sum(node.counters.frames_sent for node in lab.nodes.values()) - before - hellos == 1 + redundancy
    assert all(len(lab.deliveries[n]) == 1 for n in range(1, 8))


def test_flood_ends_at_the_hop_limit() -> None:
    lab = MeshLab(4, CHAIN, config=NetworkConfig(hop_limit=2))
    lab.run(SETTLED)

    lab.receive()
    lab.nodes[A].flood(b"plan")
    lab.transmit()
    lab.run(5)

    assert sorted(lab.deliveries) == [B, C]
    assert lab.nodes[C].counters.expired == 1


def test_routed_packet_takes_one_tick_per_hop_and_nobody_else_reads_it() -> None:
    lab = MeshLab(4, CHAIN)
    lab.run(SETTLED)

    lab.receive()
    assert lab.nodes[A].send(D, b"report")
    lab.transmit()
    lab.run(4)

    assert lab.deliveries == {D: [(SETTLED + 3, Delivery(A, b"report"))]}


def test_packet_without_a_route_is_refused() -> None:
    lab = MeshLab(2, ((0, 1),))
    lab.run(SETTLED)

    assert not lab.nodes[A].send(NodeId(77), b"report")


def test_packet_to_oneself_is_delivered_in_the_next_tick() -> None:
    node = MeshNetwork(A, NetworkConfig(), PERIOD_S)
    node.receive(0, ())

    assert node.send(A, b"note")
    assert node.transmit(0, make_presence())
    assert node.receive(1, ()) == (Delivery(A, b"note"),)


def test_lost_frames_are_repeated_until_acknowledged_and_delivered_once() -> None:
    lab = MeshLab(4, CHAIN, seed=3, loss=0.1)
    lab.run(2 * SETTLED)

    for number in range(50):
        lab.receive()
        assert lab.nodes[A].send(D, b"%d" % number)
        lab.transmit()
    lab.run(30)

    assert sorted(int(delivery.body) for _, delivery in lab.deliveries[D]) == list(range(50))
    assert sum(node.counters.duplicates for node in lab.nodes.values()) > 0


def test_packet_waits_for_the_repair_of_a_broken_route() -> None:
    lab = MeshLab(4, (*CHAIN, (0, 3)))
    lab.run(SETTLED)
    lab.links.discard((0, 3))
    lab.run(3)

    lab.receive()
    assert lab.nodes[A].route(D) == Route(D, NodeId(-1), 255, lab.nodes[A].route(D).sequence)  # type: ignore[union-attr]
    assert lab.nodes[A].send(D, b"late")
    lab.transmit()
    lab.run(16)

    assert [delivery for _, delivery in lab.deliveries[D]] == [Delivery(A, b"late")]
    assert lab.nodes[A].counters.unroutable == 0


def test_packet_for_a_dead_node_is_given_up_and_counted() -> None:
    lab = MeshLab(3, CHAIN[:2])
    lab.run(SETTLED)
    lab.leave(C)

    lab.receive()
    assert lab.nodes[A].send(C, b"hello?")
    lab.transmit()
    lab.run(40)

    assert sum(node.counters.unroutable for node in lab.nodes.values()) == 1


def test_queue_is_bounded_and_drops_the_oldest() -> None:
    lab = MeshLab(3, CHAIN[:2], config=NetworkConfig(queue_packets=4))
    lab.run(SETTLED)

    lab.receive()
    for number in range(10):
        lab.nodes[A].send(C, b"%d" % number)
    lab.transmit()
    lab.run(5)

    assert [delivery.body for _, delivery in lab.deliveries[C]] == [b"6", b"7", b"8", b"9"]
    assert lab.nodes[A].counters.unroutable == 6


def test_memory_of_packets_is_bounded() -> None:
    lab = MeshLab(2, ((0, 1),), config=NetworkConfig(seen_packets=16))
    lab.run(2)
    for number in range(40):
        lab.receive()
        lab.nodes[A].flood(b"%d" % number)
        lab.transmit()
    lab.run(1)

    assert [delivery.body for _, delivery in lab.deliveries[B]] == [b"%d" % number for number in range(40)]
    assert len(lab.nodes[B]._seen) == 16


@pytest.mark.parametrize("garbage", [b"", b"garbage", bytes(400)])
def test_bytes_that_are_no_frame_are_counted_and_dropped(garbage: bytes) -> None:
    node = MeshNetwork(A, NetworkConfig(), PERIOD_S)

    assert node.receive(0, (garbage, garbage)) == ()
    assert node.counters.corrupt == 2
    assert node.counters.frames_heard == 2
    assert node.counters.bytes_heard == 2 * len(garbage)


def test_damaged_hello_makes_no_neighbor() -> None:
    a, b = (MeshNetwork(n, NetworkConfig(), PERIOD_S) for n in (A, B))
    b.receive(0, ())
    (hello,) = b.transmit(0, make_presence())
    damaged = hello[:20] + bytes([hello[20] ^ 1]) + hello[21:]

    a.receive(0, (damaged,))

    assert dict(a.neighbors) == {}
    assert a.counters.corrupt == 1


def test_repeated_flood_frame_is_a_duplicate() -> None:
    node = MeshNetwork(A, NetworkConfig(), PERIOD_S)
    frame = encode_frame(Packet(B, 1, EVERYONE, C, EVERYONE, 9, 5, b"x"))

    assert len(node.receive(0, (frame, frame))) == 1
    assert node.receive(1, (frame,)) == ()
    assert node.counters.duplicates == 2


def test_echo_of_the_own_frames_is_ignored() -> None:
    node = MeshNetwork(A, NetworkConfig(), PERIOD_S)
    node.receive(0, ())
    node.flood(b"x")
    frames = node.transmit(0, make_presence())

    assert node.receive(1, frames) == ()
    assert dict(node.neighbors) == {}


def test_every_tick_has_one_hello_with_the_own_row_and_counters_add_up() -> None:
    node = MeshNetwork(MISSION, NetworkConfig(), PERIOD_S)
    frames = []
    for tick in range(10):
        node.receive(tick, ())
        frames.extend(node.transmit(tick, make_presence(epoch=tick)))

    hellos = [decode_frame(frame) for frame in frames]
    assert [hello.presence.epoch for hello in hellos if isinstance(hello, Hello)] == list(range(10))
    assert all(MISSION in hello.routes.destinations for hello in hellos if isinstance(hello, Hello))
    assert node.counters.frames_sent == 10
    assert node.counters.bytes_sent == sum(map(len, frames))


def test_unusable_presence_is_refused_by_name() -> None:
    node = MeshNetwork(A, NetworkConfig(), PERIOD_S)
    node.receive(0, ())

    with pytest.raises(FrameError, match="finite"):
        node.transmit(0, make_presence(np.nan))


def test_node_that_starts_late_is_silent_until_an_earlier_life_must_be_forgotten() -> None:
    lab = MeshLab(4, CHAIN)
    lab.run(SETTLED)
    lab.leave(C)
    lab.join(C)
    silent_ticks = 0
    while C not in lab.nodes[B].reachable or silent_ticks < 4:
        lab.run(1)
        silent_ticks += 1
        assert lab.routing_loop() == []
        assert silent_ticks < 30

    assert lab.config.missed_adverts < silent_ticks <= 16
    lab.run(SETTLED)
    assert {n: lab.hops(n) for n in lab.nodes} == {n: hop_counts(CHAIN, n) for n in lab.nodes}


def test_floods_of_a_restarted_node_are_not_taken_for_those_of_its_earlier_life() -> None:
    lab = MeshLab(2, ((0, 1),))
    for _ in range(SETTLED):
        lab.receive()
        lab.nodes[A].flood(b"first life")
        lab.transmit()
    lab.join(A)
    lab.receive()
    lab.deliveries.clear()
    lab.nodes[A].flood(b"second life")
    lab.transmit()
    lab.run(1)

    assert delivered(lab) == {B: [Delivery(A, b"second life")]}


def test_equal_inputs_give_equal_frames() -> None:
    def transcript() -> list[bytes]:
        lab = MeshLab(6, ((0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 5)), seed=1, loss=0.2)
        frames = []
        for _ in range(30):
            lab.receive()
            lab.nodes[A].send(D, b"x")
            lab.transmit()
            frames += [frame for inbox in lab._inboxes.values() for frame in inbox]
        return frames

    assert transcript() == transcript()


def test_a_body_too_large_is_refused_at_once_and_costs_nothing_else() -> None:
    lab = MeshLab(2, [(0, 1)])
    lab.run(SETTLED)
    lab.receive()
    for offer in (lab.nodes[A].flood, lambda body: lab.nodes[A].send(B, body), lambda body: lab.nodes[A].send(A, body)):
        with pytest.raises(FrameError, match=f"body of {BODY_MAX + 1} bytes; a packet carries at most {BODY_MAX}"):
            offer(bytes(BODY_MAX + 1))
    lab.nodes[A].flood(bytes(BODY_MAX))
    lab.transmit()
    lab.run(2)

    assert delivered(lab)[B] == [Delivery(A, bytes(BODY_MAX))]


def test_more_arrivals_than_a_frame_can_acknowledge_are_acknowledged_in_several() -> None:
    lab = MeshLab(2, [(0, 1)])
    lab.run(SETTLED)
    packets = [Packet(A, 1, B, A, B, number, 9, b"") for number in range(2500)]
    lab.nodes[B].receive(lab.tick, [encode_frame(packet) for packet in packets])

    frames = [decode_frame(data) for data in lab.nodes[B].transmit(lab.tick, make_presence())]

    acknowledged = [frame.packets for frame in frames if isinstance(frame, Acknowledgement)]
    assert [number for some in acknowledged for _, _, number in some] == list(range(2500))


def test_a_packet_for_a_broken_route_makes_its_break_known_once_more() -> None:
    said = []
    for packets in ([], [encode_frame(Packet(A, 1, B, A, C, 9, 5, b"x"))]):
        lab = MeshLab(3, CHAIN[:2])
        lab.run(SETTLED)
        lab.leave(C)
        lab.run(5)
        lab._inboxes[B] += packets
        lab.receive()
        hello = decode_frame(lab.nodes[B].transmit(lab.tick, make_presence())[0])
        assert isinstance(hello, Hello)
        said.append({int(d): int(h) for d, h in zip(hello.routes.destinations, hello.routes.hops, strict=True)}.get(C))

    assert said == [None, 255]
