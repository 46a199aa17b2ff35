"""A network without hops, for radios that all hear each other and lose nothing.

The thesis compares methods as if every robot knew at once what every other one says. With such radios there is nothing
to route, to relay or to acknowledge: whatever one node says, all others have in the next tick. What is left is who is
there and what is for whom, at a fraction of the work of the mesh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from types import MappingProxyType

from swarm_msgs_py.body_codec import BODY_MAX
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.radio import NO_ROUTES, Delivery, Frame, Hello, Packet, Presence, RadioCounters
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.labels import Route
from swarm_msgs_py.types import EVERYONE, NodeId


class IdealNetwork:
    """The radio network as one node sees it; implements `swarm_msgs_py.networking.network.Network`.

    Parameters
    ----------
    node : NodeId
        Address of this radio.
    config : NetworkConfig
    """

    def __init__(self, node: NodeId, config: NetworkConfig) -> None:
        self._node = node
        self._missed_max = config.missed_adverts
        self._presences: dict[NodeId, Presence] = {}
        self._missed: dict[NodeId, int] = {}  # ticks of silence, of who was silent in the last tick
        self._bodies: list[tuple[NodeId, bytes]] = []  # to whom, what
        self._to_self: list[Delivery] = []
        self._number = 0
        self._sent, self._heard, self._corrupt, self._unroutable = [0, 0], [0, 0], 0, 0

    @property
    def neighbors(self) -> Mapping[NodeId, Presence]:
        """Latest presence of every other node that is there, by ascending id; a live, read-only view."""
        return MappingProxyType(self._presences)

    @property
    def reachable(self) -> tuple[NodeId, ...]:
        """All other nodes that are there, ascending."""
        return tuple(self._presences)

    @property
    def counters(self) -> RadioCounters:
        """Totals since the start."""
        return RadioCounters(
            frames_sent=self._sent[0],
            bytes_sent=self._sent[1],
            frames_heard=self._heard[0],
            bytes_heard=self._heard[1],
            corrupt=self._corrupt,
            unroutable=self._unroutable,
        )

    def route(self, destination: NodeId) -> Route | None:
        """Return the route to `destination`, one hop long; None when it is not there."""
        return Route(destination, destination, 1, 0) if destination in self._presences else None

    def receive(self, tick: int, frames: Sequence[bytes]) -> tuple[Delivery, ...]:  # noqa: ARG002 - of the interface
        """Take in the frames that the radio heard, and return what was for this node.

        Parameters
        ----------
        tick : int
        frames : sequence of bytes
            In order of reception; anything that is not a frame is counted and dropped.
        """
        self._heard[0] += len(frames)
        self._heard[1] += sum(map(len, frames))
        deliveries, self._to_self = self._to_self, []
        heard: dict[NodeId, Presence] = {}
        for frame in map(_understood, frames):
            if type(frame) is Hello:  # nearly always
                heard[frame.source] = frame.presence
            elif frame is None:
                self._corrupt += 1
            elif isinstance(frame, Packet) and frame.destination in {EVERYONE, self._node}:
                deliveries.append(Delivery(frame.origin, frame.body))
        self._take(heard)
        return tuple(deliveries)

    def flood(self, body: bytes) -> None:
        """Send `body` to every other node.

        Raises
        ------
        FrameError
            If `body` is longer than `BODY_MAX` bytes.
        """
        self._put(EVERYONE, body)

    def send(self, destination: NodeId, body: bytes) -> bool:
        """Send `body` to one node; return False, and send nothing, when it is not there.

        Raises
        ------
        FrameError
            If `body` is longer than `BODY_MAX` bytes.
        """
        if destination == self._node:
            self._to_self.append(Delivery(self._node, body))
        elif destination in self._presences:
            self._put(destination, body)
        else:
            self._unroutable += 1
            return False
        return True

    def transmit(self, tick: int, presence: Presence) -> tuple[bytes, ...]:  # noqa: ARG002 - of the interface
        """Return the frames to transmit in this tick: a hello without routes, then all that was to be sent.

        Raises
        ------
        FrameError
            If `presence` does not fit a frame, e.g. a position that is not finite.
        """
        frames = [encode_frame(Hello(self._node, self._next(), presence, NO_ROUTES))]
        for destination, body in self._bodies:
            number = self._next()
            packet = Packet(self._node, number, destination, self._node, destination, number, 1, body)
            frames.append(encode_frame(packet))
        self._bodies.clear()
        self._sent[0] += len(frames)
        self._sent[1] += sum(map(len, frames))
        return tuple(frames)

    def _put(self, destination: NodeId, body: bytes) -> None:
        if len(body) > BODY_MAX:
            raise FrameError(f"body of {len(body)} bytes; a packet carries at most {BODY_MAX}")
        self._bodies.append((destination, body))

    def _take(self, heard: dict[NodeId, Presence]) -> None:
        """Take note of who is there; a node that missed a tick is still there, one that stays silent is not."""
        if list(heard) == list(self._presences):  # as ever, and in order
            self._presences = heard
            self._missed.clear()
            return
        silent = self._presences.keys() - heard.keys()
        self._missed = {node: self._missed.get(node, 0) + 1 for node in silent}
        heard |= {node: self._presences[node] for node in silent if self._missed[node] < self._missed_max}
        self._presences = {node: heard[node] for node in sorted(heard)}

    def _next(self) -> int:
        self._number = (self._number + 1) & 0xFFFF
        return self._number


@lru_cache(maxsize=256)
def _understood(data: bytes) -> Frame | None:
    """Return a frame, None if it is none; memoized, because all radios hear the same bytes."""
    try:
        return decode_frame(data)
    except FrameError:
        return None
