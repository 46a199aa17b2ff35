"""A node vanishes: where plain distance vectors count to infinity, and where an earlier life of it could mislead."""

from __future__ import annotations

import pytest
from builders import make_presence
from mesh_lab import PERIOD_S, MeshLab

from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId

CHAIN = ((0, 1), (1, 2), (2, 3))
RING = (*CHAIN, (3, 4), (4, 5), (0, 5))
SETTLED = 20


@pytest.mark.parametrize("links", [CHAIN, RING], ids=["chain", "ring"])
@pytest.mark.parametrize(("loss", "delay"), [(0.0, 0.0), (0.3, 0.0), (0.0, 0.5), (0.3, 0.5)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_hop_counts_to_a_vanished_node_stay_bounded_and_all_give_it_up_in_time(
    links: tuple[tuple[int, int], ...], loss: float, delay: float, seed: int
) -> None:
    gone = NodeId(3)
    lab = MeshLab(1 + max(map(max, links)), links, seed=seed, loss=loss, delay=delay)
    lab.run(SETTLED)
    lab.leave(gone)
    # Its neighbors notice after three silent ticks, or one more where a hello was late; the news takes a tick per hop,
    # and with losses at worst the stale time, after which nobody believes what nobody has renewed.
    stale_ticks = round(lab.config.stale_time_s / PERIOD_S)
    patience = lab.config.missed_adverts + 1 + len(lab.nodes) + (stale_ticks if loss or delay else 0)

    for _ in range(patience):
        lab.run(1)
        assert all(lab.hops(node).get(gone, 0) <= len(lab.nodes) for node in lab.nodes)
        assert lab.routing_loop() == []

    for _ in range(20):
        assert all(gone not in node.reachable for node in lab.nodes.values())
        lab.run(1)


def test_a_node_that_starts_late_says_nothing_until_all_must_have_forgotten_an_earlier_life() -> None:
    config = NetworkConfig(missed_adverts=3, delay_max_s=0.5)
    node = MeshNetwork(NodeId(0), config, PERIOD_S)
    sent = []

    for tick in range(10, 20):
        node.receive(tick, ())
        sent.append(len(node.transmit(tick, make_presence())))

    assert sent == [0] * 6 + [1] * 4  # three missed hellos, one tick of delay, one on the air and one to hear it


@pytest.mark.parametrize("late", [1, 4, 10])
def test_a_neighbor_that_keeps_hearing_an_earlier_life_is_not_led_in_a_circle_by_the_next_one(late: int) -> None:
    """Of the last hellos of node 1, every other one reaches node 0 as late as the network is told to bear."""
    config = NetworkConfig(delay_max_s=late * PERIOD_S, stale_time_s=60.0, full_dump_period_s=2.0)
    lab = MeshLab(3, CHAIN[:2], config=config)
    lab.run(SETTLED)
    for number in range(SETTLED):
        lab.run(1)
        if number % 2:
            held_back = lab._inboxes.pop(0)
            lab._late.setdefault(lab.tick - 1 + late, {})[0] = held_back
    assert NodeId(2) in lab.nodes[0].reachable

    lab.join(1)
    lab.leave(2)
    for _ in range(40):
        lab.run(1)
        assert lab.routing_loop() == []
