"""Who is heard directly: the neighbour table, fed by hello frames."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from swarm_msgs_py.messages.radio import Hello, Presence
from swarm_msgs_py.types import NodeId


class NeighborTable:
    """Direct neighbours of one radio: heard at least once within the last `missed_adverts` ticks.

    Parameters
    ----------
    missed_adverts : int
        Every radio says hello each tick; a neighbour is gone after this many ticks of silence.
    """

    def __init__(self, missed_adverts: int) -> None:
        self._missed_adverts = missed_adverts
        self._heard_at: dict[NodeId, int] = {}
        self._sequence: dict[NodeId, int] = {}
        self._presence: dict[NodeId, Presence] = {}
        self.presences: Mapping[NodeId, Presence] = MappingProxyType(self._presence)
        """Latest presence of every current neighbour, by ascending id; a live, read-only view."""

    def hear(self, tick: int, hello: Hello) -> None:
        """Take in a hello; one that was overtaken by a newer one only proves that its sender is there."""
        source = hello.source
        known = self._sequence.get(source)
        self._heard_at[source] = tick
        if known is None or 0 < (hello.sequence - known) & 0xFFFF < 0x8000:
            self._sequence[source] = hello.sequence
            self._presence[source] = hello.presence
            if known is None:
                self._sort()

    def expire(self, tick: int) -> list[NodeId]:
        """Remove the neighbours that have been silent for too long and return them, ascending."""
        limit = tick - self._missed_adverts
        gone = sorted([neighbor for neighbor, heard_at in self._heard_at.items() if heard_at <= limit])
        for neighbor in gone:
            del self._heard_at[neighbor], self._sequence[neighbor], self._presence[neighbor]
        return gone

    def is_fresh(self, neighbor: NodeId, tick: int) -> bool:
        """Return whether `neighbor` was heard in this very tick."""
        return self._heard_at.get(neighbor) == tick

    def _sort(self) -> None:
        ordered = sorted(self._presence.items())
        self._presence.clear()
        self._presence.update(ordered)
