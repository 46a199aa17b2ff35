"""Sets of ticks that take no room as long as nothing is missing in them."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Iterable


class TickRanges:
    """A set of ticks, kept as the ranges without a gap that it consists of.

    A run may last for days, and most topics bring one message per tick: one range, however long the run.

    Parameters
    ----------
    ticks : iterable of int, optional
        What is in it.
    """

    __slots__ = ("_firsts", "_lasts")

    def __init__(self, ticks: Iterable[int] = ()) -> None:
        self._firsts, self._lasts = array("q"), array("q")  # of the ranges, ascending; both ends belong to a range
        for tick in ticks:
            self.add(tick)

    def add(self, tick: int) -> None:
        """Take in a tick, in whatever order they come."""
        firsts, lasts = self._firsts, self._lasts
        if lasts and tick == lasts[-1] + 1:  # as nearly always
            lasts[-1] = tick
            return
        row = bisect_right(firsts, tick)  # the first range that begins later
        if row and tick <= lasts[row - 1]:
            return
        extends = row > 0 and lasts[row - 1] == tick - 1
        is_before = row < len(firsts) and firsts[row] == tick + 1
        if extends and is_before:
            lasts[row - 1] = lasts.pop(row)
            firsts.pop(row)
        elif extends:
            lasts[row - 1] = tick
        elif is_before:
            firsts[row] = tick
        else:
            firsts.insert(row, tick)
            lasts.insert(row, tick)

    def __len__(self) -> int:
        """Return how many ticks there are."""
        return sum(self._lasts) - sum(self._firsts) + len(self._firsts)

    @property
    def last(self) -> int:
        """The largest tick, -1 if there is none."""
        return self._lasts[-1] if self._lasts else -1

    @property
    def ranges(self) -> tuple[tuple[int, int], ...]:
        """First and last tick of each range, ascending."""
        return tuple(zip(self._firsts, self._lasts, strict=True))

    def up_to(self, last: int) -> TickRanges:
        """Return the ticks up to one, itself included."""
        kept = TickRanges()
        count = bisect_right(self._firsts, last)
        kept._firsts, kept._lasts = self._firsts[:count], array("q", (min(end, last) for end in self._lasts[:count]))
        return kept

    def with_all(self, other: TickRanges) -> TickRanges:
        """Return the ticks of both."""
        both = TickRanges()
        for first, end in sorted((*self.ranges, *other.ranges)):
            if both._lasts and first <= both._lasts[-1] + 1:
                both._lasts[-1] = max(both._lasts[-1], end)
            else:
                both._firsts.append(first)
                both._lasts.append(end)
        return both

    def count_without(self, other: TickRanges) -> int:
        """Return how many ticks of this set are not in the other one."""
        shared, mine, theirs = 0, 0, 0
        while mine < len(self._firsts) and theirs < len(other._firsts):
            first = max(self._firsts[mine], other._firsts[theirs])
            end = min(self._lasts[mine], other._lasts[theirs])
            shared += max(0, end - first + 1)
            if self._lasts[mine] < other._lasts[theirs]:
                mine += 1
            else:
                theirs += 1
        return len(self) - shared
