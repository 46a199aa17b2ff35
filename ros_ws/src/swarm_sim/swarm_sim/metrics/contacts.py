"""Collisions: how often two bodies' coverage circles, or a circle and a wall, overlapped."""

from __future__ import annotations

from collections.abc import Iterable

Pair = tuple[int, int]


def count_contacts(overlaps: Iterable[tuple[Pair, ...]]) -> int:
    """Return the number of contact episodes.

    Parameters
    ----------
    overlaps : iterable of tuple of (int, int)
        For each tick, the pairs that overlapped during it. A pair that overlaps in consecutive ticks is one episode;
        a pair that parts for a tick and touches again is two.
    """
    episodes, before = 0, frozenset[Pair]()
    for pairs in overlaps:
        now = frozenset((min(pair), max(pair)) for pair in pairs)
        episodes += len(now - before)
        before = now
    return episodes
