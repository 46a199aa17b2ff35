"""Who is heard directly: the neighbour table, fed by hello frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from swarm_msgs_py.messages.radio import Hello, Presence
from swarm_msgs_py.types import NodeId

_MEMORY = 0.95  # of what was heard, share that counts as much a tick later: the loss is averaged over 20 ticks
_PRIOR = 10.0  # hellos, none of them lost, that are taken for granted at first


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
        self._latest: dict[NodeId, Hello] = {}
        self._presences: Mapping[NodeId, Presence] | None = None
        self._said = self._heard = 0.0  # hellos, lately: those that neighbors must have sent, those that arrived

    @property
    def presences(self) -> Mapping[NodeId, Presence]:
        """Latest presence of every current neighbour, by ascending id; read-only."""
        if self._presences is None:
            latest = self._latest
            self._presences = MappingProxyType({neighbor: latest[neighbor].presence for neighbor in sorted(latest)})
        return self._presences

    @property
    def loss(self) -> float:
        """Share of the neighbors' hellos that were lost lately; one that is still on the air counts as lost."""
        return max(0.0, self._said - self._heard) / (self._said + _PRIOR)

    def hear(self, tick: int, hellos: Iterable[Hello]) -> None:
        """Take in the hellos of one tick; one overtaken by a newer one only proves that its sender is there."""
        latest, heard_at = self._latest, self._heard_at
        self._said *= _MEMORY
        self._heard *= _MEMORY
        for hello in hellos:
            source = hello.source
            known = latest.get(source)
            if known is None:
                latest[source] = hello  # what it said before cannot be known
            else:
                self._heard += 1.0
                if 0 < (hello.sequence - known.sequence) & 0xFFFF < 0x8000:
                    latest[source] = hello
                    # One hello per tick: a gap is what was lost, or comes late and counts when it does.
                    gap = (hello.presence.tick - known.presence.tick) & 0xFFFF
                    self._said += min(max(gap, 1), self._missed_adverts)
            heard_at[source] = tick
        self._presences = None

    def expire(self, tick: int) -> list[NodeId]:
        """Remove the neighbours that have been silent for too long and return them, ascending."""
        limit = tick - self._missed_adverts
        gone = sorted([neighbor for neighbor, heard_at in self._heard_at.items() if heard_at <= limit])
        for neighbor in gone:
            del self._heard_at[neighbor], self._latest[neighbor]
            self._presences = None
        return gone

    def is_fresh(self, neighbor: NodeId, tick: int) -> bool:
        """Return whether `neighbor` was heard in this very tick."""
        return self._heard_at.get(neighbor) == tick
