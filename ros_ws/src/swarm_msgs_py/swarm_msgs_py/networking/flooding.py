"""Which radios relay a flooded packet: as few as it takes for everybody to hear it a wanted number of times."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from swarm_msgs_py.body_codec import is_urgent
from swarm_msgs_py.messages.radio import Packet
from swarm_msgs_py.networking.labels import BoolArray
from swarm_msgs_py.types import IntArray, NodeId

FloodName = tuple[NodeId, int]
"""Origin and number of a flooded packet."""

_MISSES = 1e-2  # share of floods that a radio may miss; anti-entropy of the application repairs them
_LOSS_MIN = 0.03  # less than this may be frames that are late, and is no cause for more copies
_LOSS_MAX = 0.5  # where more is lost, more copies would only take the channel

_URGENT_COPIES, _FEW = 1, 20
"""Copies more of what all wait for, where there are few neighbors: then it matters that one which has just got out of
reach was counted on to relay it. In a crowd somebody else will, and the channel has no room for more."""


@dataclass(frozen=True, slots=True, eq=False)
class Vicinity:
    """What a radio knows of the links around it, from the adverts of its neighbors.

    Attributes
    ----------
    node : NodeId
        Whose vicinity.
    neighbors : (k,) int array
        Whom it hears, ascending.
    hears : (k, k) bool array
        Which neighbor (row) hears which (column) directly; True on the diagonal.
    """

    node: NodeId
    neighbors: IntArray
    hears: BoolArray


@dataclass(slots=True, eq=False)
class _Waiting:
    """A packet to transmit, those who are known to have transmitted it, and how often this radio has."""

    packet: Packet
    transmitters: list[NodeId]
    came_at: int
    since: int  # it came, or was transmitted last
    is_own: bool = False
    sent: int = 0
    is_urgent: bool = field(init=False)

    def __post_init__(self) -> None:
        self.is_urgent = is_urgent(self.packet.body)

    @property
    def rank(self) -> tuple[bool, bool]:
        return not self.is_urgent, not self.is_own

    @property
    def is_first(self) -> bool:
        return self.is_urgent or (self.is_own and not self.sent)


@dataclass(frozen=True, slots=True)
class RelayPolicy:
    """How much is done for every flooded packet.

    Attributes
    ----------
    copies : int
        How often every radio shall hear it, where there are enough radios around it.
    repeats : int
        How often one radio may transmit it.
    answer_ticks : int
        Time in which those who hear it would have been heard to relay it.
    """

    copies: int
    repeats: int = 1
    answer_ticks: int = 2


class FloodQueue:
    """Flooded packets of one radio that wait for transmission: urgent ones first, then own ones, then oldest first.

    Whether a packet must be relayed is decided as late as possible, with all copies heard until then: what waits for
    its turn is often relayed by others in the meantime (as in Peng and Lu, "On the reduction of broadcast redundancy in
    mobile ad hoc networks", MobiHoc 2000). Where frames are lost, a radio transmits a packet again as long as some
    neighbor has not had its copies and has not been heard to transmit it either (passive acknowledgement, Jubin and
    Tornow, "The DARPA packet radio network protocols", Proc. IEEE 1987): a bridge between two parts has no second radio
    that could do it.

    Parameters
    ----------
    capacity : int
        Own packets that may wait, and as many of others; of more, the oldest is dropped.
    stay_ticks_max : float
        One that has waited longer than this is dropped.
    """

    def __init__(self, capacity: int, stay_ticks_max: float = math.inf) -> None:
        self._capacity = capacity
        self._stay = stay_ticks_max
        self._waiting: dict[FloodName, _Waiting] = {}  # in order of arrival
        self.dropped = 0
        """Packets given up because too many waited, or they did for too long."""

    def __len__(self) -> int:
        return len(self._waiting)

    def put_own(self, tick: int, packet: Packet) -> None:
        """Take over a packet of this radio, which is transmitted in any case."""
        self._put(_Waiting(packet, [], tick, tick, is_own=True))

    def put(self, tick: int, packet: Packet, transmitter: NodeId) -> None:
        """Take over a packet to relay, heard from `transmitter` for the first time."""
        self._put(_Waiting(packet, [transmitter], tick, tick))

    def _put(self, entry: _Waiting) -> None:
        self._waiting[entry.packet.origin, entry.packet.number] = entry
        if len(self._waiting) > self._capacity:
            alike = [name for name, other in self._waiting.items() if other.is_own == entry.is_own]
            if len(alike) > self._capacity:
                del self._waiting[alike[0]]
                self.dropped += 1

    def overhear(self, name: FloodName, transmitter: NodeId) -> None:
        """Note that `transmitter` has transmitted a packet, too."""
        entry = self._waiting.get(name)
        if entry is not None:
            entry.transmitters.append(transmitter)

    def next(
        self,
        tick: int,
        vicinity: Vicinity,
        policy: RelayPolicy,
        room: float = math.inf,
        *,
        first_only: bool = False,
    ) -> Packet | None:
        """Take out the next packet that must be transmitted, and those before it that others have relayed; or None.

        Parameters
        ----------
        tick : int
        vicinity : Vicinity
        policy : RelayPolicy
        room : float
            Bytes that the channel has room for in a tick. Of all who could relay a packet, only as many do so at once
            as fit; the others take their turns in later ticks, if it is still wanted then.
        first_only : bool
            Whether only urgent packets and first transmissions of own ones are meant.
        """
        for name, entry in sorted(self._waiting.items(), key=lambda item: item[1].rank):
            packet = entry.packet
            if first_only and not entry.is_first:
                continue
            if tick - entry.came_at > self._stay:
                del self._waiting[name]
                self.dropped += not entry.sent
                continue
            if entry.is_own and not entry.sent:
                return self._sent(tick, name, policy)
            if entry.sent and tick < entry.since + policy.answer_ticks:
                continue
            is_doubled = entry.is_urgent and len(vicinity.neighbors) <= _FEW
            copies = policy.copies + (_URGENT_COPIES if is_doubled else 0)
            is_wanted = entry.sent < policy.repeats and must_relay(
                packet, entry.transmitters, vicinity, copies, entry.sent
            )
            if not is_wanted:
                del self._waiting[name]
                continue
            rivals = np.count_nonzero(rivals_of(packet, entry.transmitters, vicinity))
            if entry.sent or tick >= entry.since + int(rivals * len(packet.body) / room):
                return self._sent(tick, name, policy)
        return None

    def _sent(self, tick: int, name: FloodName, policy: RelayPolicy) -> Packet:
        """Note that a packet goes now, for the last time unless it may be repeated."""
        entry = self._waiting[name]
        entry.sent += 1
        entry.since = tick
        if entry.sent >= policy.repeats:
            del self._waiting[name]
        return entry.packet


def policy_against(loss: float, redundancy: int, delay: int = 0) -> RelayPolicy:
    """Return what makes it as good as certain that a copy arrives when `loss` of them are lost.

    Parameters
    ----------
    loss : float
        Share of frames lost.
    redundancy : int
        Copies beyond one where none are.
    delay : int
        Ticks that a frame may take beyond the usual one.
    """
    if loss <= _LOSS_MIN:
        return RelayPolicy(1 + redundancy)
    needed = math.ceil(math.log(_MISSES) / math.log(min(loss, _LOSS_MAX)))
    return RelayPolicy(max(1 + redundancy, needed), needed, 2 + 2 * delay)


def must_relay(packet: Packet, transmitters: Iterable[NodeId], vicinity: Vicinity, copies: int, sent: int = 0) -> bool:
    """Return whether some neighbor would hear `packet` fewer than `copies` times unless this radio transmits it.

    A neighbor hears the transmitters that it is linked with, and it will hear those of the other holders of the packet
    (neighbors of this radio that are linked with a transmitter) which come before this radio in an order that differs
    from packet to packet and is the same at all radios. The radio that comes first of those who could serve a neighbor
    always does, so in a mesh at rest and without loss nobody is left out, however little the radios know of their
    vicinity: what they do not know, they do not rely on. What this radio has transmitted `sent` times, every neighbor
    has had as many copies of.

    References
    ----------
    Wu and Dai, "Broadcasting in ad hoc networks based on self-pruning", INFOCOM 2003: the coverage condition with
    two-hop information, here for one wanted copy and more.
    """
    neighbors, hears = vicinity.neighbors, vicinity.hears
    has_sent = np.isin(neighbors, list(transmitters))
    heard = sent + hears[has_sent].sum(axis=0)
    expected = heard + hears[rivals_of(packet, transmitters, vicinity)].sum(axis=0)
    wanting = (expected < copies) & ~has_sent & (neighbors != packet.origin)
    return bool(wanting.any())


def rivals_of(packet: Packet, transmitters: Iterable[NodeId], vicinity: Vicinity) -> BoolArray:
    """Return which neighbors hold the packet too, as far as one can tell, and come before this radio in its order."""
    has_sent = np.isin(vicinity.neighbors, list(transmitters))
    holds: BoolArray = vicinity.hears[has_sent].any(axis=0) & ~has_sent
    is_before: BoolArray = _ranks(packet, vicinity.neighbors) < _ranks(packet, np.array([vicinity.node]))
    return holds & is_before


def _ranks(packet: Packet, nodes: IntArray) -> IntArray:
    """Return the order of radios for one packet: Knuth's multiplicative hash of both, so that all take turns."""
    salt = packet.origin * 7919 + packet.number * 104729
    return (nodes * 40503 + salt) * 2654435761 & 0xFFFFFFFF
