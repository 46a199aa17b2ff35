"""Delivery of packets over the mesh: flooding and routed unicast on top of neighbours and DSDV routes.

A radio says one hello per tick. A *flooded* packet is transmitted by its origin and relayed by as few other radios as
it takes, by each of them once, or more often where frames are lost (`flooding`). A *routed* packet goes hop by hop,
from radio to radio, each of which acknowledges it to the previous one; one that hears no acknowledgement transmits
again, over another feasible successor if there is one. A packet whose route is broken waits for a while for its repair.
Packets of either sort keep to the radio's share of the channel (`pacer`): what the share has no room for waits for the
next ticks.
"""

from __future__ import annotations

from collections.abc import Container, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from swarm_msgs_py.body_codec import BODY_MAX
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.radio import (
    Acknowledgement,
    Delivery,
    Frame,
    Hello,
    Packet,
    Presence,
    RadioCounters,
)
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.dsdv import RouteTable
from swarm_msgs_py.networking.flooding import FloodQueue, Vicinity, policy_against
from swarm_msgs_py.networking.labels import Advert, Route, advert_of
from swarm_msgs_py.networking.lifetimes import PacketMemory, PacketNumbers, delay_ticks_max, stay_ticks_max
from swarm_msgs_py.networking.neighbors import NeighborTable
from swarm_msgs_py.networking.outbox import Outbox
from swarm_msgs_py.networking.pacer import Pacer
from swarm_msgs_py.types import EVERYONE, NodeId

_ACKNOWLEDGED_PER_FRAME = 1000


class MeshNetwork:
    """The radio network as one node sees it.

    Each tick: `receive` first, then any number of `flood` and `send`, and `transmit` last.

    Parameters
    ----------
    node : NodeId
        Address of this radio.
    config : NetworkConfig
    period_s : float
        Length of a tick [s].
    """

    def __init__(self, node: NodeId, config: NetworkConfig, period_s: float) -> None:
        self._node = node
        self._config = config
        self._neighbor_table = NeighborTable(config.missed_adverts)
        self._routes = RouteTable(node, config, period_s)
        self._outbox = Outbox(config, period_s)
        self._delay_max = delay_ticks_max(config, period_s)
        self._delay = 0  # longest yet of a frame [ticks]
        self._silence = config.missed_adverts + 2 + self._delay_max
        self._speaks_from: int | None = None
        self._tick = 0
        self._frame_number = 0
        self._packet_numbers = PacketNumbers()
        self._seen = PacketMemory(config, period_s)
        self._floods = FloodQueue(config.queue_packets, stay_ticks_max(config, period_s))
        self._pacer = Pacer(config, period_s)
        self._to_acknowledge: list[tuple[NodeId, NodeId, int]] = []
        self._to_self: list[Delivery] = []
        self._sent = [0, 0]
        self._heard = [0, 0]
        self._corrupt = self._duplicates = self._expired = 0

    @property
    def neighbors(self) -> Mapping[NodeId, Presence]:
        """Latest presence of each current neighbour, by ascending id; a live, read-only view."""
        return self._neighbor_table.presences

    @property
    def reachable(self) -> tuple[NodeId, ...]:
        """Nodes to which there is a route, ascending."""
        return self._routes.reachable

    @property
    def counters(self) -> RadioCounters:
        """Totals since the start."""
        return RadioCounters(
            frames_sent=self._sent[0],
            bytes_sent=self._sent[1],
            frames_heard=self._heard[0],
            bytes_heard=self._heard[1],
            corrupt=self._corrupt,
            duplicates=self._duplicates,
            expired=self._expired,
            unroutable=self._outbox.dropped + self._floods.dropped,
        )

    def route(self, destination: NodeId) -> Route | None:
        """Return the route to `destination`; None when there is none, not even a broken one."""
        return self._routes.route(destination)

    def next_hops(self, destination: NodeId) -> list[NodeId]:
        """Return the neighbours that may carry a packet to `destination` without ever leading it in a circle.

        Best first: those heard in this tick, then fewest hops.
        """
        successors = self._routes.successors(destination)
        fresh = [neighbor for _, neighbor in successors if self._neighbor_table.is_fresh(neighbor, self._tick)]
        return fresh + [neighbor for _, neighbor in successors if neighbor not in fresh]

    def receive(self, tick: int, frames: Sequence[bytes]) -> tuple[Delivery, ...]:
        """Take in the frames that the radio heard, and return what was for this node.

        Parameters
        ----------
        tick : int
        frames : sequence of bytes
            In order of reception; anything that is not a frame is counted and dropped.
        """
        self._begin(tick)
        self._heard[0] += len(frames)
        self._heard[1] += sum(map(len, frames))
        hellos: list[Hello] = []
        adverts: list[Advert] = []
        packets: list[Packet] = []
        for data in frames:
            try:
                frame, advert = _understood(data)
            except FrameError:
                self._corrupt += 1
                continue
            if frame.source == self._node:
                continue
            if advert is not None:
                hellos.append(frame)  # type: ignore[arg-type]  # only a hello has an advert
                adverts.append(advert)
            elif isinstance(frame, Packet):
                packets.append(frame)
            elif isinstance(frame, Acknowledgement):
                self._outbox.acknowledge(self._node, frame)
        self._note_delay(tick, hellos)
        self._update_routes(tick, hellos, adverts)
        deliveries, self._to_self = self._to_self, []
        # Who has come farther has set out earlier: an answer that took a shorter way must not overtake what it answers.
        for packet in sorted(packets, key=lambda packet: packet.hops_left):
            self._take(packet, deliveries)
        return tuple(deliveries)

    def flood(self, body: bytes) -> None:
        """Send `body` to every node that can be reached, without acknowledgement.

        Raises
        ------
        FrameError
            If `body` is longer than `BODY_MAX` bytes.
        """
        _check_size(body)
        packet = self._packet(EVERYONE, EVERYONE, body)
        self._remember((packet.origin, packet.number))
        self._floods.put_own(self._tick, packet)

    def send(self, destination: NodeId, body: bytes) -> bool:
        """Send `body` to one node; return False, and send nothing, when there is no route to it.

        A route that broke lately counts as one: the packet waits for its repair.

        Raises
        ------
        FrameError
            If `body` is longer than `BODY_MAX` bytes.
        """
        _check_size(body)
        if destination == self._node:
            self._to_self.append(Delivery(self._node, body))
            return True
        if self._routes.route(destination) is None:
            return False
        self._outbox.put(self._tick, self._packet(EVERYONE, destination, body))
        return True

    def transmit(self, tick: int, presence: Presence) -> tuple[bytes, ...]:
        """Return the frames to transmit in this tick: a hello, then acknowledgements, floods and routed packets.

        Raises
        ------
        FrameError
            If `presence` does not fit a frame, e.g. a position that is not finite.
        """
        self._begin(tick)
        frames = []
        if self._is_listening():
            rows = self._routes.advertise(tick, self._neighbor_table.loss)
            frames.append(encode_frame(Hello(self._node, self._next_frame(), presence, rows)))
        if self._to_acknowledge:
            arrived = tuple(dict.fromkeys(self._to_acknowledge))
            for first in range(0, len(arrived), _ACKNOWLEDGED_PER_FRAME):
                some = arrived[first : first + _ACKNOWLEDGED_PER_FRAME]
                frames.append(encode_frame(Acknowledgement(self._node, self._next_frame(), some)))
            self._to_acknowledge.clear()
        frames += self._paced(tick)
        self._sent[0] += len(frames)
        self._sent[1] += sum(map(len, frames))
        return tuple(frames)

    # -- one tick ------------------------------------------------------------------------------------------------------

    def _begin(self, tick: int) -> None:
        """Start the tick, and the node's life if it is its first.

        Who starts at tick 0 has no earlier life. Who starts later may have had one: others may still route through it,
        on what it knew then. It keeps silent, and learns nothing, until they must have noticed (see `dsdv`).
        """
        self._tick = tick
        self._seen.expire(tick)
        if self._speaks_from is None:
            self._speaks_from = tick + self._silence if tick > 0 else 0

    def _is_listening(self) -> bool:
        return self._speaks_from is not None and self._tick >= self._speaks_from

    def _update_routes(self, tick: int, hellos: list[Hello], adverts: list[Advert]) -> None:
        if self._is_listening():
            self._neighbor_table.hear(tick, hellos)
        self._routes.lose(tick, self._neighbor_table.expire(tick))
        while self._is_listening() and adverts:
            # One advert per neighbour at a time: a second one in a tick was delayed on the air.
            batch = list({advert.source: advert for advert in reversed(adverts)}.values())
            self._routes.merge(tick, batch)
            adverts = [advert for advert in adverts if advert not in batch] if len(batch) < len(adverts) else []
        self._routes.expire(tick)

    def _take(self, packet: Packet, deliveries: list[Delivery]) -> None:
        if packet.destination == EVERYONE:
            self._take_flood(packet, deliveries)
        elif packet.next_hop == self._node and self._is_listening():
            self._take_routed(packet, deliveries)

    def _take_flood(self, packet: Packet, deliveries: list[Delivery]) -> None:
        if packet.origin == self._node or not self._remember((packet.origin, packet.number)):
            self._duplicates += 1
            self._floods.overhear((packet.origin, packet.number), packet.source)
            return
        deliveries.append(Delivery(packet.origin, packet.body))
        if packet.hops_left <= 1:
            self._expired += 1
        else:
            self._floods.put(self._tick, replace(packet, hops_left=packet.hops_left - 1), packet.source)

    def _take_routed(self, packet: Packet, deliveries: list[Delivery]) -> None:
        self._to_acknowledge.append((packet.source, packet.origin, packet.number))
        if packet.destination == self._node:
            if self._remember((packet.origin, packet.number)):
                deliveries.append(Delivery(packet.origin, packet.body))
            else:
                self._duplicates += 1
        elif not self._remember((packet.origin, packet.number, packet.source, packet.hops_left)):
            self._duplicates += 1  # transmitted again because the acknowledgement was lost
        elif packet.hops_left <= 1:
            self._expired += 1
        else:
            self._routes.repeat(self._tick, packet.destination)
            self._outbox.put(self._tick, replace(packet, hops_left=packet.hops_left - 1))

    def _paced(self, tick: int) -> list[bytes]:
        """Return the frames of the packets that the radio's share of the channel has room for.

        First plans, and what this radio itself has to tell everybody; then what neighbors ask of each other, because it
        mends what floods have lost and takes one transmission; then floods of others, and last what crosses the swarm
        to one node.
        """
        if not self._floods and not self._outbox:
            return []
        self._pacer.fill(tick, self._routes.crowd())
        frames = self._flooded(tick, first_only=True)
        frames += self._routed(tick, self.neighbors)
        frames += self._flooded(tick)
        return frames + self._routed(tick)

    def _flooded(self, tick: int, *, first_only: bool = False) -> list[bytes]:
        frames: list[bytes] = []
        if not self._floods:
            return frames
        neighbors = np.array(list(self.neighbors), dtype=np.int64)
        vicinity = Vicinity(self._node, neighbors, self._routes.vicinity(neighbors))
        policy = policy_against(self._neighbor_table.loss, self._config.flood_redundancy, self._delay)
        while self._pacer.is_open:
            packet = self._floods.next(tick, vicinity, policy, self._pacer.room, first_only=first_only)
            if packet is None:
                break
            frames.append(self._encode(packet, EVERYONE))
            self._pacer.spend(len(frames[-1]))
        return frames

    def _routed(self, tick: int, destinations: Container[NodeId] | None = None) -> list[bytes]:
        due = self._outbox.due(tick, self.next_hops, self._pacer, delay=self._delay, destinations=destinations)
        return [self._encode(packet, next_hop) for packet, next_hop in due]

    def _note_delay(self, tick: int, hellos: Iterable[Hello]) -> None:
        """Learn how long frames take here beyond the tick that they always take, from the clocks in hellos."""
        for hello in hellos:
            late = (tick - 1 - hello.presence.tick) & 0xFFFF
            if self._delay < late <= self._delay_max:
                self._delay = late

    # -- small parts ---------------------------------------------------------------------------------------------------

    def _remember(self, name: Hashable) -> bool:
        """Return whether `name` is new, and remember it."""
        return self._seen.add(self._tick, name)

    def _packet(self, next_hop: NodeId, destination: NodeId, body: bytes) -> Packet:
        ends = self._node, destination, self._packet_numbers.take(self._tick)
        return Packet(self._node, 0, next_hop, *ends, self._config.hop_limit, body)

    def _encode(self, packet: Packet, next_hop: NodeId) -> bytes:
        return encode_frame(replace(packet, source=self._node, sequence=self._next_frame(), next_hop=next_hop))

    def _next_frame(self) -> int:
        self._frame_number = (self._frame_number + 1) & 0xFFFF
        return self._frame_number


def _check_size(body: bytes) -> None:
    if len(body) > BODY_MAX:
        raise FrameError(f"body of {len(body)} bytes; a packet carries at most {BODY_MAX}")


@lru_cache(maxsize=8192)
def _understood(data: bytes) -> tuple[Frame, Advert | None]:
    """Return a frame and, for a hello, its rows as labels; memoised, because many radios hear the same bytes."""
    frame = decode_frame(data)
    return frame, advert_of(frame.source, frame.routes) if isinstance(frame, Hello) else None
