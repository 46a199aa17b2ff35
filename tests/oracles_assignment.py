"""Assignments found by trying them all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from swarm_msgs_py.messages.bodies import UNREACHABLE, CostRow
from swarm_msgs_py.types import NodeId

Taken = dict[NodeId, int]


def every_assignment(rows: Sequence[CostRow], used: frozenset[int] = frozenset()) -> Iterator[Taken]:
    """Yield every assignment of robots of one type to different goals that they have a path to, some without a goal.

    In the order of robots: a lower goal of a lower robot comes first, no goal comes last.
    """
    if not rows:
        yield {}
        return
    first, *others = rows
    for goal, cost in enumerate(first.costs):
        if goal not in used and cost != UNREACHABLE:
            for taken in every_assignment(others, used | {goal}):
                yield {first.robot: goal, **taken}
    yield from every_assignment(others, used)


def lengths(rows: Sequence[CostRow], taken: Taken) -> list[int]:
    """Return weight times cost of every robot that has a goal."""
    return [row.weight * int(row.costs[taken[row.robot]]) for row in rows if row.robot in taken]


def longest(rows: Sequence[CostRow], taken: Taken) -> int:
    """Return the largest of them, 0 if nobody has a goal."""
    return max(lengths(rows, taken), default=0)


def best_total(rows: Sequence[CostRow], limit: float = float("inf")) -> Taken:
    """Return, of all assignments within a limit that leave the fewest robots without a goal, the first of least sum."""
    allowed = [taken for taken in every_assignment(rows) if longest(rows, taken) <= limit]
    return min(allowed, key=lambda taken: (-len(taken), sum(lengths(rows, taken))))


def least_longest(rows: Sequence[CostRow]) -> int:
    """Return the longest path of an assignment in which that is as short as it can be, for as many as possible."""
    return min((-len(taken), longest(rows, taken)) for taken in every_assignment(rows))[1]
