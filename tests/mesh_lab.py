"""A radio world for tests of the mesh: nodes, links that can be changed at will, loss, delay and corruption."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from builders import make_presence
from oracles import find_cycle

from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId

PERIOD_S = 0.5


class MeshLab:
    """Runs mesh networks in lockstep, as the swarm does.

    Parameters
    ----------
    nodes : int
        Nodes 0 .. nodes - 1 are alive at the start.
    links : iterable of (int, int)
        Who hears whom, both ways.
    loss, delay : float
        Probability that a frame is lost, or arrives late, per receiver.
    late_ticks_max : int
        How many ticks late at most; any number of them is equally likely.
    """

    def __init__(
        self,
        nodes: int,
        links: Iterable[tuple[int, int]] = (),
        *,
        config: NetworkConfig | None = None,
        seed: int = 0,
        loss: float = 0.0,
        delay: float = 0.0,
        late_ticks_max: int = 1,
    ) -> None:
        self.config = config or NetworkConfig()
        self.nodes = {node: self._make(node) for node in range(nodes)}
        self.links = {(min(link), max(link)) for link in links}
        self.loss, self.delay, self.late_ticks_max = loss, delay, late_ticks_max
        self.tick = 0
        self.deliveries: dict[int, list[tuple[int, Delivery]]] = {}
        self._rng = np.random.default_rng(seed)
        self._inboxes: dict[int, list[bytes]] = {}
        self._late: dict[int, dict[int, list[bytes]]] = {}  # by the tick after which they arrive

    def _make(self, node: int) -> MeshNetwork:
        return MeshNetwork(NodeId(node), self.config, PERIOD_S)

    def join(self, node: int) -> None:
        """Start a node with an empty memory, whether or not it lived before."""
        self.nodes[node] = self._make(node)

    def leave(self, node: int) -> None:
        """End a node; frames on their way from it still arrive."""
        del self.nodes[node]

    def receive(self) -> None:
        """Begin a tick: every node takes in what it hears. Then the test may `send` and `flood`."""
        inboxes, self._inboxes = self._inboxes, self._late.pop(self.tick, {})
        for name, node in self.nodes.items():
            for delivery in node.receive(self.tick, inboxes.get(name, [])):
                self.deliveries.setdefault(name, []).append((self.tick, delivery))

    def transmit(self) -> None:
        """End the tick: every node transmits, and the links decide who will hear it."""
        for name, node in self.nodes.items():
            frames = node.transmit(self.tick, make_presence(float(name), tick=self.tick & 0xFFFF))
            for a, b in self.links:
                other = b if a == name else a
                if name in (a, b) and other in self.nodes:
                    for frame in frames:
                        self._carry(frame, other)
        self.tick += 1

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.receive()
            self.transmit()

    def _carry(self, frame: bytes, receiver: int) -> None:
        if self.loss and self._rng.random() < self.loss:
            return
        inboxes = self._inboxes
        if self.delay and self._rng.random() < self.delay:
            late = 1 if self.late_ticks_max == 1 else int(self._rng.integers(1, self.late_ticks_max + 1))
            inboxes = self._late.setdefault(self.tick + late, {})
        inboxes.setdefault(receiver, []).append(frame)

    def hops(self, node: int) -> dict[int, int]:
        """Return the hop count of every valid route of `node`, itself included."""
        routes = {other: self.nodes[node].route(NodeId(other)) for other in self.nodes[node].reachable}
        return {node: 0} | {other: route.hops for other, route in routes.items() if route}

    def routing_loop(self) -> list[int]:
        """Return the nodes of a circle that packets to some destination could run in, [] when there is none."""
        destinations = {NodeId(other) for node in self.nodes.values() for other in node.reachable}
        for destination in sorted(destinations):
            arrows = {name: node.next_hops(destination) for name, node in self.nodes.items() if name != destination}
            if cycle := find_cycle(arrows):
                return [destination, *cycle]
        return []
