from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from builders import make_presence

from swarm_msgs_py.messages.radio import Hello, RouteRows
from swarm_msgs_py.networking.neighbors import NeighborTable
from swarm_msgs_py.types import NodeId

NO_ROWS = RouteRows(*(np.zeros(0, dtype=np.int64) for _ in range(3)))


def make_hello(source: int, sequence: int = 1, x: float = 0.0) -> Hello:
    return Hello(NodeId(source), sequence, make_presence(x), NO_ROWS)


def test_neighbors_are_listed_by_ascending_id() -> None:
    table = NeighborTable(3)

    for source in (5, 1, 3):
        table.hear(0, [make_hello(source)])

    assert list(table.presences) == [1, 3, 5]


def test_neighbor_is_gone_after_three_missed_hellos() -> None:
    table = NeighborTable(3)
    table.hear(10, [make_hello(7)])

    assert table.expire(12) == []
    assert table.expire(13) == [7]
    assert list(table.presences) == []


def test_latest_presence_counts_even_when_hellos_overtake_each_other() -> None:
    table = NeighborTable(3)
    table.hear(0, [make_hello(7, 2, x=2.0)])

    table.hear(0, [make_hello(7, 1, x=1.0)])

    assert table.presences[NodeId(7)].position[0] == 2.0


@pytest.mark.parametrize(("before", "after"), [(1, 2), (65535, 0), (65000, 100)])
def test_frame_counter_may_wrap_around(before: int, after: int) -> None:
    table = NeighborTable(3)
    table.hear(0, [make_hello(7, before, x=1.0)])

    table.hear(1, [make_hello(7, after, x=2.0)])

    assert table.presences[NodeId(7)].position[0] == 2.0


def test_neighbor_that_comes_back_may_count_from_anywhere() -> None:
    table = NeighborTable(3)
    table.hear(0, [make_hello(7, 900, x=1.0)])
    table.expire(3)

    table.hear(9, [make_hello(7, 1, x=2.0)])

    assert table.presences[NodeId(7)].position[0] == 2.0


def test_only_who_was_heard_in_this_tick_is_fresh() -> None:
    table = NeighborTable(3)
    table.hear(4, [make_hello(7)])

    assert table.is_fresh(NodeId(7), 4)
    assert not table.is_fresh(NodeId(7), 5)
    assert not table.is_fresh(NodeId(8), 4)


def test_presences_cannot_be_changed_from_outside() -> None:
    with pytest.raises(TypeError):
        NeighborTable(3).presences[NodeId(1)] = make_presence()  # type: ignore[index]


def hear_for(table: NeighborTable, said: Iterable[tuple[int, int]]) -> None:
    """Let the table hear a hello that was said by radio 1 in each second tick of the pairs, in the first of them."""
    for tick, spoken in said:
        hello = Hello(NodeId(1), spoken, make_presence(tick=spoken), NO_ROWS)
        table.hear(tick, [hello])
        table.expire(tick)


def test_the_loss_is_the_share_of_hellos_that_did_not_come() -> None:
    table = NeighborTable(missed_adverts=3)

    hear_for(table, [(tick, tick) for tick in range(400) if tick % 4])

    assert table.loss == pytest.approx(0.25 * 20 / 30, abs=0.03)  # twenty hellos known, ten taken for granted


def test_hellos_that_come_late_are_not_lost() -> None:
    table = NeighborTable(missed_adverts=3)

    hear_for(table, [(tick, tick ^ 1) for tick in range(400)])

    assert table.loss <= 0.05


def test_a_clock_that_leaps_is_not_taken_for_thousands_of_lost_hellos() -> None:
    table = NeighborTable(missed_adverts=3)

    for tick, spoken in ((1, 1), (2, 5000)):
        table.hear(tick, [Hello(NodeId(1), tick, make_presence(tick=spoken), NO_ROWS)])

    assert 0.0 < table.loss < 0.2
