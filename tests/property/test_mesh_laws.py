"""What the mesh promises on every graph, with a breadth-first search as the reference."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_lab import MeshLab
from oracles import hop_counts

from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.types import NodeId

Links = frozenset[tuple[int, int]]
MOST = 9


@st.composite
def graphs(draw: st.DrawFn, *, connected: bool = False) -> tuple[int, Links]:
    nodes = draw(st.integers(2, MOST))
    pairs = [(i, j) for j in range(nodes) for i in range(j)]
    links = set(draw(st.lists(st.sampled_from(pairs), max_size=2 * nodes)))
    if connected:
        links |= {(draw(st.integers(0, node - 1)), node) for node in range(1, nodes)}
    return nodes, frozenset(links)


def rounds_to_converge(nodes: int) -> int:
    return nodes + 2


@given(graphs())
@settings(max_examples=40)
def test_routes_converge_to_least_hop_counts(graph: tuple[int, Links]) -> None:
    nodes, links = graph
    lab = MeshLab(nodes, links)

    lab.run(rounds_to_converge(nodes))

    assert {n: lab.hops(n) for n in range(nodes)} == {n: hop_counts(links, n) for n in range(nodes)}


@given(graphs(), graphs(), st.integers(1, 8))
@settings(max_examples=25)
def test_routes_converge_again_after_any_change_of_the_links(
    first: tuple[int, Links], second: tuple[int, Links], ticks: int
) -> None:
    nodes = max(first[0], second[0])
    lab = MeshLab(nodes, first[1])
    lab.run(ticks)
    lab.links = set(second[1])

    for _ in range(36):  # neighbours time out, stale rows go, and every destination renumbers itself
        lab.run(1)
        assert lab.routing_loop() == []

    assert {n: lab.hops(n) for n in range(nodes)} == {n: hop_counts(second[1], n) for n in range(nodes)}


@given(
    st.data(),
    st.integers(0, 2**16),
    st.sampled_from([0.0, 0.1, 0.3, 0.6]),
    st.sampled_from([0.0, 0.4]),
)
@settings(max_examples=25)
def test_no_loop_at_any_tick_under_loss_delay_moving_links_joins_and_departures(
    data: st.DataObject, seed: int, loss: float, delay: float
) -> None:
    lab = MeshLab(6, seed=seed, loss=loss, delay=delay)
    pairs = [(i, j) for j in range(6) for i in range(j)]
    lab.links = set(data.draw(st.lists(st.sampled_from(pairs), min_size=6)))

    for _ in range(25):
        event = data.draw(st.sampled_from(["none", "none", "link", "link", "leave", "join"]))
        if event == "link":
            lab.links ^= {data.draw(st.sampled_from(pairs))}
        node = data.draw(st.integers(0, 5)) if event in ("leave", "join") else 0
        if event == "leave" and node in lab.nodes:
            lab.leave(node)
        if event == "join":  # restarts a living node, too
            lab.join(node)
        for _ in range(data.draw(st.integers(1, 4))):
            lab.run(1)
            assert lab.routing_loop() == []


@given(graphs(), st.data())
@settings(max_examples=30)
def test_flood_reaches_exactly_the_component_once(graph: tuple[int, Links], data: st.DataObject) -> None:
    nodes, links = graph
    origin = data.draw(st.integers(0, nodes - 1))
    lab = MeshLab(nodes, links)
    lab.run(data.draw(st.integers(0, 14)))

    lab.receive()
    lab.nodes[origin].flood(b"plan")
    lab.transmit()
    lab.run(nodes)

    arrived = {node: [delivery for _, delivery in deliveries] for node, deliveries in lab.deliveries.items()}
    assert arrived == {n: [Delivery(NodeId(origin), b"plan")] for n in hop_counts(links, origin) if n != origin}
    sent = [node.counters.frames_sent - lab.tick for node in lab.nodes.values()]
    assert max(sent) <= 1


@given(graphs(connected=True), st.data())
@settings(max_examples=30)
def test_routed_packet_arrives_once_after_as_many_ticks_as_hops(graph: tuple[int, Links], data: st.DataObject) -> None:
    nodes, links = graph
    origin, destination = data.draw(st.permutations(range(nodes)))[:2]
    lab = MeshLab(nodes, links)
    lab.run(rounds_to_converge(nodes))

    lab.receive()
    assert lab.nodes[origin].send(NodeId(destination), b"report")
    sent_at = lab.tick
    lab.transmit()
    lab.run(nodes + 2)

    hops = hop_counts(links, origin)[destination]
    assert lab.deliveries == {destination: [(sent_at + hops, Delivery(NodeId(origin), b"report"))]}
