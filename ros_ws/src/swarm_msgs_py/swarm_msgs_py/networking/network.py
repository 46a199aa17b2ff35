"""What a node asks of its radio network, whichever way packets travel, and the one place where the way is chosen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from swarm_msgs_py.messages.radio import Delivery, Presence, RadioCounters
from swarm_msgs_py.networking.config import NetworkConfig, NetworkModel
from swarm_msgs_py.networking.ideal import IdealNetwork
from swarm_msgs_py.networking.labels import Route
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import NodeId


class Network(Protocol):
    """The radio network as one node sees it.

    Each tick: `receive` first, then any number of `flood` and `send`, and `transmit` last.
    """

    @property
    def neighbors(self) -> Mapping[NodeId, Presence]:
        """Latest presence of each current neighbor, by ascending id; read-only."""
        ...

    @property
    def reachable(self) -> tuple[NodeId, ...]:
        """Nodes to which there is a route, ascending."""
        ...

    @property
    def counters(self) -> RadioCounters:
        """Totals since the start."""
        ...

    def route(self, destination: NodeId) -> Route | None:
        """Return the route to a node; None when there is none."""
        ...

    def receive(self, tick: int, frames: Sequence[bytes]) -> tuple[Delivery, ...]:
        """Take in the frames that the radio heard, and return what was for this node."""
        ...

    def flood(self, body: bytes) -> None:
        """Send a body to every node that can be reached."""
        ...

    def send(self, destination: NodeId, body: bytes) -> bool:
        """Send a body to one node; return False, and send nothing, when there is no route to it."""
        ...

    def transmit(self, tick: int, presence: Presence) -> tuple[bytes, ...]:
        """Return the frames to transmit in this tick."""
        ...


def make_network(node: NodeId, config: NetworkConfig, period_s: float) -> Network:
    """Return the network of one node.

    Parameters
    ----------
    node : NodeId
    config : NetworkConfig
    period_s : float
        Length of a tick [s].
    """
    if config.model is NetworkModel.IDEAL:
        return IdealNetwork(node, config)
    return MeshNetwork(node, config, period_s)
