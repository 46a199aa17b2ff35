"""Routed packets on their way: repeated until the next hop acknowledges them, held while there is no route."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, field

from swarm_msgs_py.frames import encode_frame
from swarm_msgs_py.messages.radio import Acknowledgement, Packet
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.lifetimes import patience_ticks, stay_ticks_max
from swarm_msgs_py.networking.pacer import Pacer
from swarm_msgs_py.types import EVERYONE, NodeId

_OVERHEAD = len(encode_frame(Packet(NodeId(0), 0, EVERYONE, NodeId(0), EVERYONE, 0, 0, b"")))  # bytes around a body


@dataclass(slots=True, eq=False)
class _Pending:
    packet: Packet
    since: int
    next_attempt: int
    tried: list[NodeId] = field(default_factory=list)


class Outbox:
    """Routed packets of one radio that no next hop has acknowledged yet.

    Parameters
    ----------
    config : NetworkConfig
    period_s : float
        Length of a tick [s].
    """

    def __init__(self, config: NetworkConfig, period_s: float) -> None:
        self._capacity = config.queue_packets
        self._attempts = config.attempts
        self._patience = patience_ticks(config, period_s)
        self._hold = round(config.hold_time_s / period_s)
        self._stay = stay_ticks_max(config, period_s)
        self._pending: list[_Pending] = []
        self.dropped = 0
        """Packets given up: no route or no turn for too long, no acknowledgement, or too many waiting."""

    def __len__(self) -> int:
        return len(self._pending)

    def put(self, tick: int, packet: Packet) -> None:
        """Take over a packet; when too many wait, the oldest is dropped."""
        self._pending.append(_Pending(packet, tick, tick))
        if len(self._pending) > self._capacity:
            del self._pending[0]
            self.dropped += 1

    def acknowledge(self, node: NodeId, frame: Acknowledgement) -> None:
        """Forget the packets that a neighbour acknowledges to `node`."""
        if not self._pending:
            return
        arrived = {(origin, number) for transmitter, origin, number in frame.packets if transmitter == node}
        if arrived:
            self._pending = [
                entry
                for entry in self._pending
                if (entry.packet.origin, entry.packet.number) not in arrived or frame.source not in entry.tried
            ]

    def due(
        self,
        tick: int,
        successors: Callable[[NodeId], list[NodeId]],
        pacer: Pacer,
        *,
        delay: int = 0,
        destinations: Container[NodeId] | None = None,
    ) -> list[tuple[Packet, NodeId]]:
        """Return the packets to transmit now, each with its next hop.

        Parameters
        ----------
        tick : int
        successors : callable
            Possible next hops to a destination, best first.
        pacer : Pacer
            Pays for the packets; those for which it has nothing left wait.
        delay : int
            Ticks that a frame may take beyond the usual one, and its acknowledgement too.
        destinations : container of int or None
            Only packets to these; None: to anyone.
        """
        if not self._pending:
            return []
        ready, gone = [], set()
        for entry in self._pending:
            age, is_wanted = tick - entry.since, destinations is None or entry.packet.destination in destinations
            if age <= self._stay and (tick < entry.next_attempt or not is_wanted):
                continue
            choices = successors(entry.packet.destination)
            is_hopeless = len(entry.tried) >= self._attempts or (not choices and age >= self._hold)
            if is_hopeless or age > self._stay:
                self.dropped += 1
                gone.add(id(entry))
            elif choices and pacer.is_open:
                next_hop = min(choices, key=entry.tried.count)  # the best of those tried least
                entry.tried.append(next_hop)
                entry.next_attempt = tick + self._patience + 2 * delay
                ready.append((entry.packet, next_hop))
                pacer.spend(_OVERHEAD + len(entry.packet.body))
        self._pending = [entry for entry in self._pending if id(entry) not in gone]
        return ready
