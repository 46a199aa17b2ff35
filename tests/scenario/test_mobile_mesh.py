"""Fifty robots that drive about in the arena: routed packets arrive, over nearly shortest routes, and never circle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from mesh_lab import PERIOD_S, MeshLab
from oracles import hop_counts

from swarm_msgs_py.types import NodeId

ROBOTS = 50
HALF_SIDE_M, RANGE_M, SPEED = 45.0, 25.0, 0.5
WARM_UP, MEASURED, COOL_DOWN = 20, 50, 30
"""Ticks to converge, to send packets in, and to deliver the last of them."""


def random_waypoint_links(seed: int) -> Iterator[set[tuple[int, int]]]:
    """Yield the links of each tick while every robot drives from one random point to the next."""
    rng = np.random.default_rng(seed)
    positions, goals = rng.uniform(-HALF_SIDE_M, HALF_SIDE_M, (2, ROBOTS, 2))
    while True:
        ways = goals - positions
        lengths = np.linalg.norm(ways, axis=1)
        positions += ways * np.minimum(1.0, SPEED * PERIOD_S / np.maximum(lengths, 1e-9))[:, None]
        arrived = lengths <= SPEED * PERIOD_S
        goals[arrived] = rng.uniform(-HALF_SIDE_M, HALF_SIDE_M, (arrived.sum(), 2))
        near = np.linalg.norm(positions[:, None] - positions, axis=2) < RANGE_M
        rows, columns = np.nonzero(np.triu(near, 1))
        yield set(zip(rows.tolist(), columns.tolist(), strict=True))


@pytest.mark.parametrize(
    ("loss", "delivery", "stretch", "routeless"), [(0.0, 0.99, 1.05, 0.05), (0.1, 0.95, 1.05, 0.1)]
)
def test_packets_between_connected_robots_arrive_over_short_routes(
    loss: float, delivery: float, stretch: float, routeless: float
) -> None:
    lab = MeshLab(ROBOTS, seed=1, loss=loss)
    rng = np.random.default_rng(2)
    links = random_waypoint_links(seed=1)
    sent, without_route, hops_used, hops_needed = 0, 0, 0, 0

    for tick in range(WARM_UP + MEASURED + COOL_DOWN):
        lab.links = next(links)
        lab.receive()
        assert tick % 10 or lab.routing_loop() == []
        if WARM_UP <= tick < WARM_UP + MEASURED:
            for origin, destination in rng.integers(ROBOTS, size=(10, 2)).tolist():
                needed = hop_counts(lab.links, origin).get(destination)
                if not needed:  # not connected, or to itself
                    continue
                lab.nodes[origin].send(NodeId(destination), b"%d" % sent)
                sent += 1
                used = lab.hops(origin).get(destination)
                if used is None:
                    without_route += 1
                else:  # a stale claim that is shorter than any path makes up for no detour
                    hops_used, hops_needed = hops_used + max(used, needed), hops_needed + needed
        lab.transmit()

    arrived = sum(len(deliveries) for deliveries in lab.deliveries.values())
    assert arrived / sent >= delivery
    assert hops_used / hops_needed <= stretch
    assert without_route / sent <= routeless
