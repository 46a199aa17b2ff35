"""Slow, obvious references to compare against."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping


def hop_counts(links: Iterable[tuple[int, int]], start: int) -> dict[int, int]:
    """Return the least number of hops from `start` to every node that can be reached, by breadth-first search."""
    around: dict[int, set[int]] = {}
    for a, b in links:
        around.setdefault(a, set()).add(b)
        around.setdefault(b, set()).add(a)
    hops, frontier = {start: 0}, deque([start])
    while frontier:
        node = frontier.popleft()
        for neighbor in around.get(node, ()):
            if neighbor not in hops:
                hops[neighbor] = hops[node] + 1
                frontier.append(neighbor)
    return hops


def find_cycle(arrows: Mapping[int, Iterable[int]]) -> list[int]:
    """Return the nodes of one directed cycle, [] when there is none, by depth-first search."""
    finished: set[int] = set()

    def search(node: int, trail: list[int]) -> list[int]:
        if node in trail:
            return trail[trail.index(node) :]
        if node in finished:
            return []
        for following in arrows.get(node, ()):
            if cycle := search(following, [*trail, node]):
                return cycle
        finished.add(node)
        return []

    for start in arrows:
        if cycle := search(start, []):
            return cycle
    return []
