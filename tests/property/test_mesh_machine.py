"""A mesh in which anything may happen never routes in a circle, never counts to infinity, and finds back to rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from mesh_lab import PERIOD_S, MeshLab
from oracles import hop_counts

from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.types import NodeId

NODES = 6
PAIRS = [(i, j) for j in range(NODES) for i in range(j)]
QUEUE = 4
CONFIG = NetworkConfig(queue_packets=QUEUE, rows_per_hello=4, full_dump_period_s=2.0)
REST = 60
"""Ticks in which old lives are forgotten, stale rows go, and every destination renumbers itself several times."""

nodes = st.integers(0, NODES - 1)


class LivingMesh(RuleBasedStateMachine):
    """Whole mesh networks, frames on the air and all: links, radios and nodes come and go while packets travel."""

    @initialize(
        seed=st.integers(0, 2**16), links=st.sets(st.sampled_from(PAIRS), min_size=4), late=st.sampled_from([1, 4, 6])
    )
    def begin(self, seed: int, links: set[tuple[int, int]], late: int) -> None:
        """Frames will be as late as the network is told to bear."""
        config = replace(CONFIG, delay_max_s=late * PERIOD_S)
        self.lab = MeshLab(NODES, links, seed=seed, config=config, late_ticks_max=late)
        self.parted: set[tuple[int, int]] = set()

    @rule(loss=st.sampled_from([0.0, 0.1, 0.3, 0.6]), delay=st.sampled_from([0.0, 0.5, 0.9]))
    def change_the_radio(self, loss: float, delay: float) -> None:
        """A delayed frame arrives with, and before, later ones of its sender."""
        self.lab.loss, self.lab.delay = loss, delay

    @rule(pair=st.sampled_from(PAIRS))
    def change_a_link(self, pair: tuple[int, int]) -> None:
        self.lab.links ^= {pair}

    @precondition(lambda self: not self.parted)
    @rule(side=st.sets(nodes, min_size=1, max_size=NODES - 1))
    def partition(self, side: set[int]) -> None:
        self.parted = {link for link in self.lab.links if (link[0] in side) != (link[1] in side)}
        self.lab.links -= self.parted

    @precondition(lambda self: self.parted)
    @rule()
    def merge(self) -> None:
        self.lab.links |= self.parted
        self.parted = set()

    @rule(node=nodes)
    def leave(self, node: int) -> None:
        self.lab.nodes.pop(node, None)

    @rule(node=nodes)
    def join(self, node: int) -> None:
        """A node that died starts again, a living one restarts; it remembers nothing."""
        self.lab.join(node)

    @rule(origin=nodes, destination=nodes, count=st.integers(1, 2 * QUEUE))
    def send(self, origin: int, destination: int, count: int) -> None:
        if origin in self.lab.nodes:
            for _ in range(count):
                self.lab.nodes[origin].send(NodeId(destination), b"x")

    @rule(origin=nodes, count=st.integers(1, 2 * QUEUE))
    def flood(self, origin: int, count: int) -> None:
        if origin in self.lab.nodes:
            for _ in range(count):
                self.lab.nodes[origin].flood(b"x")

    @rule(ticks=st.integers(1, 9))
    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.lab.run(1)
            self.check()

    @rule(seed=st.integers(0, 2**16))
    def unrest(self, seed: int) -> None:
        """Nodes restart and links change all the time, while most frames are late and many are lost."""
        rng = np.random.default_rng(seed)
        self.lab.loss, self.lab.delay = 0.3, 0.8
        for _ in range(40):
            if rng.random() < 0.15:
                self.lab.links ^= {PAIRS[rng.integers(len(PAIRS))]}
            if rng.random() < 0.1:
                self.lab.join(int(rng.integers(NODES)))
            self.lab.run(1)
            self.check()

    @invariant()
    def check(self) -> None:
        assert self.lab.routing_loop() == []
        for name, node in self.lab.nodes.items():
            assert len(node._outbox) <= QUEUE
            assert len(node._floods) <= 2 * QUEUE
            for destination in node.reachable:
                route = node.route(destination)
                assert route is not None
                assert route.next_hop in node.neighbors
                assert 1 <= route.hops < NODES, f"{name} counts to {route.hops} for {destination}"

    def teardown(self) -> None:
        """When nothing changes any more, every table holds the shortest paths and nothing else."""
        if not hasattr(self, "lab"):
            return
        self.lab.loss = self.lab.delay = 0.0
        for _ in range(REST):
            self.lab.run(1)
            self.check()
        live = {(a, b) for a, b in self.lab.links if a in self.lab.nodes and b in self.lab.nodes}
        assert {n: self.lab.hops(n) for n in self.lab.nodes} == {n: hop_counts(live, n) for n in self.lab.nodes}
        assert all(len(node._outbox) == len(node._floods) == 0 for node in self.lab.nodes.values())


LivingMesh.TestCase.settings = settings(max_examples=15, stateful_step_count=20, deadline=None)
TestLivingMesh = LivingMesh.TestCase
