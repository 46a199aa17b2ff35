"""The network of radios that all hear each other: the same interface as the mesh, and nothing to route."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.body_codec import BODY_MAX
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.radio import Delivery, Presence
from swarm_msgs_py.networking.config import NetworkConfig, NetworkModel
from swarm_msgs_py.networking.ideal import IdealNetwork
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.networking.network import Network, make_network
from swarm_msgs_py.types import MISSION, NodeId

PERIOD_S = 0.5
CONFIG = NetworkConfig(model=NetworkModel.IDEAL)


def presence(x: float, tick: int) -> Presence:
    return Presence(
        position=np.array([x, 0.0]),
        velocity=np.zeros(2),
        covariance=np.eye(2),
        shared=0.0,
        tick=tick,
        robot_type=1,
        is_beacon=True,
        mode=0,
        epoch=0,
        digest=0,
    )


class Air:
    """Carries every frame of some nodes to all others of them, in the next tick."""

    def __init__(self, *nodes: int) -> None:
        self.nodes: dict[NodeId, Network] = {NodeId(n): make_network(NodeId(n), CONFIG, PERIOD_S) for n in nodes}
        self.tick = 0
        self._sent: dict[NodeId, tuple[bytes, ...]] = {}

    def step(self, *silent: int) -> dict[NodeId, tuple[Delivery, ...]]:
        """Run one tick; who is silent is heard by nobody. Return what each node was given."""
        given = {
            node: network.receive(self.tick, [f for other, sent in self._sent.items() if other != node for f in sent])
            for node, network in self.nodes.items()
        }
        self._sent = {
            n: network.transmit(self.tick, presence(float(n), self.tick)) for n, network in self.nodes.items()
        }
        for node in silent:
            self._sent[NodeId(node)] = ()
        self.tick += 1
        return given


def test_the_setting_chooses_the_network() -> None:
    assert isinstance(make_network(NodeId(1), CONFIG, PERIOD_S), IdealNetwork)
    assert isinstance(make_network(NodeId(1), NetworkConfig(), PERIOD_S), MeshNetwork)


def test_everybody_is_a_neighbor_of_everybody_a_tick_later() -> None:
    air = Air(2, 0, 1, MISSION)
    air.step()
    air.step()

    assert air.nodes[NodeId(1)].reachable == (0, 2, MISSION)
    assert {n: float(p.position[0]) for n, p in air.nodes[NodeId(1)].neighbors.items()} == {
        0: 0.0,
        2: 2.0,
        MISSION: float(MISSION),
    }


def test_routes_are_one_hop_long() -> None:
    air = Air(0, 1)
    assert air.nodes[NodeId(0)].route(NodeId(1)) is None
    air.step()
    air.step()

    route = air.nodes[NodeId(0)].route(NodeId(1))
    assert route is not None
    assert (route.next_hop, route.hops) == (1, 1)
    assert air.nodes[NodeId(0)].route(NodeId(9)) is None


def test_a_flood_reaches_all_others_once_and_in_the_next_tick() -> None:
    air = Air(0, 1, 2)
    air.nodes[NodeId(0)].flood(b"to all")
    assert air.step() == {0: (), 1: (), 2: ()}

    assert air.step() == {0: (), 1: (Delivery(NodeId(0), b"to all"),), 2: (Delivery(NodeId(0), b"to all"),)}
    assert air.step() == {0: (), 1: (), 2: ()}


def test_what_is_sent_to_one_is_given_to_that_one_alone() -> None:
    air = Air(0, 1, 2)
    air.step()
    air.step()
    assert air.nodes[NodeId(0)].send(NodeId(2), b"to you")
    air.step()

    assert air.step() == {0: (), 1: (), 2: (Delivery(NodeId(0), b"to you"),)}


def test_a_node_can_send_to_itself() -> None:
    air = Air(0)
    assert air.nodes[NodeId(0)].send(NodeId(0), b"note")

    assert air.step() == {0: (Delivery(NodeId(0), b"note"),)}


def test_nothing_is_sent_to_who_is_not_there() -> None:
    air = Air(0)

    assert not air.nodes[NodeId(0)].send(NodeId(5), b"anybody")
    assert air.nodes[NodeId(0)].counters.unroutable == 1


def test_a_node_that_misses_a_tick_is_still_there() -> None:
    air = Air(0, 1, 2)
    air.step()
    air.step(1)
    air.step()

    assert air.nodes[NodeId(0)].reachable == (1, 2)


def test_a_node_that_stays_silent_is_gone_as_in_the_mesh() -> None:
    air = Air(0, 1, 2)
    air.step()
    for _ in range(CONFIG.missed_adverts):
        air.step(1)
    assert air.nodes[NodeId(0)].reachable == (1, 2)
    air.step(1)

    assert air.nodes[NodeId(0)].reachable == (2,)


def test_silence_is_counted_anew_after_each_word() -> None:
    air = Air(0, 1)
    for tick in range(4 * CONFIG.missed_adverts):
        air.step(*([1] if tick % CONFIG.missed_adverts else []))

    assert air.nodes[NodeId(0)].reachable == (1,)


def test_damage_is_counted_and_dropped() -> None:
    network = make_network(NodeId(0), CONFIG, PERIOD_S)
    good = make_network(NodeId(1), CONFIG, PERIOD_S)
    good.flood(b"body")
    frames = good.transmit(0, presence(1.0, 0))
    spoiled = bytes([frames[1][0] ^ 0xFF]) + frames[1][1:]

    assert network.receive(1, [frames[0], spoiled, b""]) == ()
    assert network.counters.corrupt == 2
    assert network.counters.frames_heard == 3


def test_a_body_that_no_packet_carries_is_refused() -> None:
    network = make_network(NodeId(0), CONFIG, PERIOD_S)

    with pytest.raises(FrameError, match="a packet carries at most"):
        network.flood(bytes(BODY_MAX + 1))
