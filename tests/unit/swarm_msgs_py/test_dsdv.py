from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.messages.radio import HOPS_INFINITE, RouteRows
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.dsdv import RouteTable
from swarm_msgs_py.networking.labels import Route, advert_of
from swarm_msgs_py.types import NodeId

A, B, C, D, E = (NodeId(n) for n in range(5))
QUIET = NetworkConfig(full_dump_period_s=60.0, stale_time_s=600.0)  # no dump within these tests
GONE = HOPS_INFINITE


def make_table(node: NodeId = A, config: NetworkConfig = QUIET, sequence: int = 0) -> RouteTable:
    return RouteTable(node, config, 1.0, sequence)


def hear(table: RouteTable, neighbor: NodeId, *rows: tuple[int, int, int], tick: int = 1) -> None:
    """Let `neighbor` advertise (destination, hops, sequence) rows."""
    hear_all(table, {neighbor: rows}, tick)


def hear_all(table: RouteTable, rows_of: dict[NodeId, tuple[tuple[int, int, int], ...]], tick: int = 1) -> None:
    adverts = []
    for neighbor, rows in rows_of.items():
        columns = np.array(rows, dtype=np.int64).reshape(-1, 3).T
        adverts.append(advert_of(neighbor, RouteRows(*columns)))
    table.merge(tick, adverts)


def said(table: RouteTable, tick: int = 1) -> dict[int, tuple[int, int]]:
    """Return what the table advertises: hops and sequence by destination."""
    rows = table.advertise(tick)
    columns = (rows.destinations.tolist(), rows.hops.tolist(), rows.sequences.tolist())
    return {destination: (hops, sequence) for destination, hops, sequence in zip(*columns, strict=True)}


def test_new_neighbor_is_one_hop_away_under_its_own_number() -> None:
    table = make_table(B)

    hear(table, A, (A, 0, 100))

    assert table.route(A) == Route(A, A, 1, 100)
    assert table.reachable == (A,)


def test_new_node_is_passed_on_with_one_hop_more() -> None:
    """Spec 5.1: A sends <A, A, 0, 100>; B passes it on; C stores <A, B, 2, 100>."""
    b, c = make_table(B), make_table(C)
    hear(b, A, (A, 0, 100))

    c.merge(2, [advert_of(B, b.advertise(1))])

    assert c.route(A) == Route(A, B, 2, 100)


def test_table_of_the_thesis_figure_holds_under_even_numbers() -> None:
    """F3.7 with the numbers of valid routes made even (spec 5.3, rule 1)."""
    h, g, i = 7, 6, 8
    table = make_table(B)

    hear_all(
        table,
        {
            A: ((A, 0, 122), (i, 1, 516)),
            C: ((C, 0, 212), (h, 1, 168), (g, 2, 372)),
            D: ((D, 0, 300), (E, 1, 432)),
        },
    )

    expected = {A: (A, 1, 122), i: (A, 2, 516), C: (C, 1, 212), h: (C, 2, 168), g: (C, 3, 372), E: (D, 2, 432)}
    for destination, (next_hop, hops, sequence) in expected.items():
        assert table.route(NodeId(destination)) == Route(NodeId(destination), next_hop, hops, sequence)


def test_newer_number_wins_over_fewer_hops() -> None:
    table = make_table()
    hear(table, B, (D, 1, 100))

    hear(table, C, (D, 5, 102))

    assert table.route(D) == Route(D, C, 6, 102)


def test_of_equally_new_offers_the_shorter_wins_and_then_the_lower_neighbor() -> None:
    table = make_table()

    hear_all(table, {E: ((D, 1, 100),), C: ((D, 1, 100),), B: ((D, 3, 100),)})

    assert table.route(D) == Route(D, C, 2, 100)


@pytest.mark.parametrize("offer", [(D, 1, 98), (D, 4, 100)], ids=["older", "as new and longer"])
def test_worse_offer_changes_nothing(offer: tuple[int, int, int]) -> None:
    table = make_table()
    hear(table, B, (D, 2, 100))

    hear(table, C, offer)

    assert table.route(D) == Route(D, B, 3, 100)


def test_numbers_wrap_around() -> None:
    table = make_table()
    hear(table, B, (D, 0, 65534))

    hear(table, C, (D, 7, 0))

    assert table.route(D) == Route(D, C, 8, 0)
    hear(table, B, (D, 0, 65534))
    assert table.route(D) == Route(D, C, 8, 0)


def test_own_number_wraps_around_with_the_full_dumps() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=1.0), sequence=65532)

    assert [said(table, tick)[A] for tick in range(3)] == [(0, 65534), (0, 0), (0, 2)]


def test_broken_link_makes_every_route_through_it_infinite_with_the_next_odd_number() -> None:
    """Spec 5.1: B hears nothing more from D, through which it reached D and E."""
    table = make_table(B)
    hear_all(table, {D: ((D, 0, 100), (E, 1, 432)), A: ((A, 0, 122),)})
    said(table, 1)

    table.lose(2, [D])

    assert table.route(D) == Route(D, NodeId(-1), GONE, 101)
    assert table.route(E) == Route(E, NodeId(-1), GONE, 433)
    assert table.reachable == (A,)
    assert said(table, 2) == {B: (0, 0), D: (GONE, 101), E: (GONE, 433)}


def test_break_is_believed_from_the_next_hop_and_passed_on_at_once() -> None:
    table = make_table()
    hear(table, B, (D, 1, 100))
    said(table, 1)

    hear(table, B, (D, GONE, 101), tick=2)

    assert table.route(D) == Route(D, NodeId(-1), GONE, 101)
    assert said(table, 2)[D] == (GONE, 101)


def test_break_elsewhere_does_not_concern_a_route_that_does_not_lead_there() -> None:
    table = make_table()
    hear_all(table, {B: ((D, 1, 100),), C: ((D, 4, 100),)})

    hear(table, C, (D, GONE, 101))

    assert table.route(D) == Route(D, B, 2, 100)


def test_old_even_number_does_not_revive_a_broken_route() -> None:
    table = make_table()
    hear(table, B, (D, 1, 100))
    table.lose(2, [B])

    hear(table, C, (D, 1, 100), tick=3)

    assert table.reachable == ()
    hear(table, C, (D, 1, 102), tick=4)
    assert table.route(D) == Route(D, C, 2, 102)


def test_neighbor_with_an_equally_new_and_short_route_replaces_a_lost_next_hop_without_a_break() -> None:
    table = make_table()
    hear_all(table, {B: ((D, 1, 100),), C: ((D, 1, 100),), E: ((D, 2, 100),)})
    said(table, 1)

    table.lose(2, [B])

    assert table.route(D) == Route(D, C, 2, 100)
    assert D not in said(table, 2)


def test_longer_way_of_the_same_number_is_no_replacement() -> None:
    """Else C could lead back to here: this is where counting to infinity would begin."""
    table = make_table()
    hear_all(table, {B: ((D, 1, 100),), C: ((D, 2, 100),)})

    table.lose(2, [B])

    assert table.reachable == ()
    assert table.successors(D) == []


def test_who_holds_a_newer_route_answers_a_break_at_once() -> None:
    table = make_table()
    hear(table, B, (D, 1, 102))
    said(table, 1)
    assert D not in said(table, 2)

    hear(table, C, (D, GONE, 101), tick=3)

    assert said(table, 3)[D] == (2, 102)


def test_destination_that_is_said_to_be_lost_outnumbers_the_rumor() -> None:
    table = make_table(A, sequence=100)

    hear(table, B, (A, GONE, 105))

    assert said(table)[A] == (0, 106)


@pytest.mark.parametrize("rumor", [51, 101, 99])
def test_destination_that_hears_both_of_an_earlier_life_and_of_a_break_outnumbers_both(rumor: int) -> None:
    table = make_table(A, sequence=50)

    hear_all(table, {B: ((A, 3, 100),), C: ((A, GONE, rumor),)})

    assert table.sequence == 102


@pytest.mark.parametrize("heard", [50 + (1 << 15) - 1, 50 + (1 << 15) - 2, 50 + (1 << 15)])
def test_number_too_far_off_to_tell_whether_it_is_newer_is_not_followed(heard: int) -> None:
    table = make_table(A, sequence=50)

    hear(table, B, (A, GONE if heard % 2 else 3, heard))

    assert 0 <= table.sequence - 50 < 1 << 15


def test_destination_that_has_forgotten_its_number_outnumbers_its_earlier_life() -> None:
    table = make_table(A)

    hear(table, B, (A, 1, 500))

    assert said(table)[A] == (0, 502)


def test_rumor_older_than_the_own_number_is_ignored() -> None:
    table = make_table(A, sequence=100)

    hear(table, B, (A, GONE, 99))

    assert said(table)[A] == (0, 100)


def test_neighbor_that_restarted_with_a_low_number_is_told_the_one_to_exceed() -> None:
    config = NetworkConfig(full_dump_period_s=4.0, stale_time_s=2.0)
    table = make_table(A, config)
    hear(table, B, (B, 0, 500), tick=1)
    table.lose(2, [B])
    table.expire(4)

    hear(table, B, (B, 0, 0), tick=8)

    assert table.reachable == ()
    assert said(table, 8)[B] == (GONE, 501)


def test_only_what_changed_is_advertised_between_full_dumps() -> None:
    config = NetworkConfig(full_dump_period_s=4.0)
    table = make_table(A, config)
    hear_all(table, {B: ((B, 0, 100), (C, 1, 100))}, tick=1)

    assert set(said(table, 1)) == {A, B, C}
    hear(table, B, (C, 1, 102), tick=2)
    assert set(said(table, 2)) == {A, C}
    assert set(said(table, 3)) == {A}
    assert set(said(table, 4)) == {A, B, C}


def test_own_number_rises_by_two_with_each_full_dump_only() -> None:
    table = make_table(B, NetworkConfig(full_dump_period_s=3.0))

    numbers = [said(table, tick)[B][1] for tick in range(8)]

    assert numbers == [0, 2, 2, 2, 4, 4, 4, 6]


def test_stale_route_is_deleted_and_its_number_stays_a_floor() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=60.0, stale_time_s=6.0))
    hear(table, B, (D, 1, 100), tick=1)

    table.expire(6)
    assert table.reachable == (D,)
    table.expire(7)
    assert table.reachable == ()
    assert table.route(D) is None
    assert D not in said(table, 60)

    hear(table, B, (D, 1, 100), tick=61)
    assert table.reachable == ()
    hear(table, B, (D, 1, 102), tick=62)
    assert table.reachable == (D,)


def test_broken_route_is_kept_until_stale_with_its_odd_number() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=60.0, stale_time_s=6.0))
    hear(table, B, (D, 1, 100), tick=1)
    table.lose(4, [B])

    table.expire(9)
    assert table.route(D) == Route(D, NodeId(-1), GONE, 101)
    table.expire(10)
    assert table.route(D) is None


@pytest.mark.parametrize("row", [(D, 1, 101), (D, GONE, 100), (D, 254, 100), (0xFFFF, 1, 100)])
def test_illegal_rows_are_ignored(row: tuple[int, int, int]) -> None:
    """Odd and finite, even and infinite, one hop short of infinity, the flood address."""
    table = make_table()

    hear(table, B, row)

    assert table.reachable == ()
    assert set(said(table)) == {A}


def test_repeated_destination_counts_once() -> None:
    table = make_table()

    hear(table, B, (D, 3, 100), (D, 1, 100))

    assert table.route(D) == Route(D, B, 4, 100)


def test_longer_route_of_a_newer_number_is_used_at_once_and_advertised_after_settling() -> None:
    """Perkins and Bhagwat: wait twice the mean settling time, because the shorter route usually follows."""
    table = make_table(A, NetworkConfig(full_dump_period_s=60.0, settling_max_s=5.0))
    for sequence in range(100, 110, 2):  # the short route always follows two ticks after the long one
        hear(table, C, (D, 4, sequence), tick=10 * sequence)
        said(table, 10 * sequence)
        hear(table, B, (D, 1, sequence), tick=10 * sequence + 2)
        said(table, 10 * sequence + 2)

    hear(table, C, (D, 4, 110), tick=1100)

    assert table.route(D) == Route(D, C, 5, 110)
    assert D not in said(table, 1100)
    hear(table, B, (D, 1, 110), tick=1102)
    assert said(table, 1102)[D] == (2, 110)


def test_one_quick_settling_does_not_undo_what_many_slow_ones_have_taught() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=60.0, settling_max_s=5.0))
    for sequence in range(100, 110, 2):
        hear(table, C, (D, 4, sequence), tick=10 * sequence)
        hear(table, B, (D, 1, sequence), tick=10 * sequence + 2)
    hear(table, B, (D, 1, 110), tick=1100)
    hear(table, C, (D, 4, 112), tick=1120)

    assert [D in said(table, tick) for tick in range(1120, 1125)] == [False, False, False, True, False]


def test_damped_advert_is_sent_when_no_shorter_route_comes() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=60.0, settling_max_s=2.0))
    for sequence in range(100, 110, 2):
        hear(table, C, (D, 4, sequence), tick=10 * sequence)
        hear(table, B, (D, 1, sequence), tick=10 * sequence + 2)
    said(table, 1090)

    hear(table, C, (D, 4, 110), tick=1100)

    assert [D in said(table, tick) for tick in (1100, 1101, 1102, 1103)] == [False, False, True, False]


def test_rows_that_do_not_fit_a_hello_follow_in_the_next_and_breaks_go_first() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=60.0, rows_per_hello=3))
    hear_all(table, {B: tuple((d, 1, 100) for d in (10, 11, 12)), C: ((13, 1, 100),)})
    table.lose(2, [C])

    assert set(said(table, 2)) == {A, 10, 13}
    assert set(said(table, 3)) == {A, 11, 12}
    assert set(said(table, 4)) == {A}


def test_table_grows_with_the_swarm() -> None:
    table = make_table()

    hear_all(table, {NodeId(n): ((n, 0, 100), (1000 + n, 1, 100)) for n in range(1, 101)})

    assert len(table.reachable) == 200
    assert table.route(NodeId(1042)) == Route(NodeId(1042), NodeId(42), 2, 100)


def test_successors_are_ranked_by_hops_with_the_next_hop_first() -> None:
    table = make_table()
    hear(table, C, (D, 1, 100))

    hear_all(table, {B: ((D, 1, 100),), E: ((D, 1, 98),)})

    assert table.route(D) == Route(D, C, 2, 100)
    assert table.successors(D) == [(2, C), (2, B)]


def test_offer_is_forgotten_before_its_number_looks_new_again() -> None:
    table = make_table(A, NetworkConfig(full_dump_period_s=1.0, stale_time_s=600.0))
    hear(table, C, (D, 1, 0), (C, 0, 0))
    for tick, sequence in enumerate((0x3000, 0x6000, 0x9000), start=2):
        hear(table, B, (D, 1, sequence), (C, 1, sequence), tick=tick)
        said(table, tick)

    assert table.successors(D) == [(2, B)]
