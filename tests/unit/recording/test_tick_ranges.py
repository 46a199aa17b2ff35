"""Sets of ticks as ranges: the same as plain sets, and small where nothing is missing."""

from __future__ import annotations

import sys

from hypothesis import given
from hypothesis import strategies as st
from tick_builders import make_tick

from bringup.engine import TickRecord
from recording.audit import Audit
from recording.tick_ranges import TickRanges
from swarm_msgs_py.topics import CLOCK

ticks = st.lists(st.integers(0, 30), max_size=40)
LONG = 20_000


@given(ticks, ticks, st.integers(-1, 31))
def test_ranges_are_the_sets_that_they_stand_for(some: list[int], others: list[int], last: int) -> None:
    mine, theirs = TickRanges(some), TickRanges(others)

    assert len(mine) == len(set(some))
    assert mine.last == max(some, default=-1)
    assert mine.count_without(theirs) == len(set(some) - set(others))
    assert [tick for first, end in mine.ranges for tick in range(first, end + 1)] == sorted(set(some))
    assert mine.up_to(last).ranges == TickRanges(tick for tick in some if tick <= last).ranges
    assert mine.with_all(theirs).ranges == TickRanges([*some, *others]).ranges


def test_an_audit_of_a_long_run_needs_no_more_room_than_one_of_a_short_run() -> None:
    audit = Audit()
    record: TickRecord = make_tick(0, [[0.0, 0.0], [1.0, 0.0]])
    for tick in range(LONG):
        object.__setattr__(record, "tick", tick)
        audit.expect(record)

    assert len(audit._due[CLOCK.topic()]) == LONG
    assert {ranges.ranges for ranges in audit._due.values()} == {((0, LONG - 1),)}
    assert sum(map(sys.getsizeof, audit._due.values())) < 100 * len(audit._due)
