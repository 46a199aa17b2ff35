from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.config import RadioConfig
from swarm_sim.radio.links import LinkTable
from swarm_sim.radio.medium import Medium

RADIOS = (NodeId(0), NodeId(1), NodeId(2), MISSION)
ALL_LINKED = LinkTable(~np.eye(4, dtype=np.bool_), np.ones((4, 4)))
ALIVE = np.ones(4, dtype=np.bool_)
A, B, C, M = RADIOS
Outboxes = Mapping[NodeId, Sequence[bytes]]


def make_medium(period_s: float = 0.5, seed: int = 1, **settings: float) -> Medium:
    return Medium(RadioConfig(**settings), RADIOS, period_s, seed)  # type: ignore[arg-type]


def exchange(
    medium: Medium, outboxes: Outboxes, tick: int = 0, links: LinkTable = ALL_LINKED
) -> list[tuple[bytes, ...]]:
    medium.transmit(tick, outboxes, links)
    return medium.collect(tick + 1, ALIVE)


def test_frames_arrive_in_the_next_tick_by_sender_then_by_order_of_transmission() -> None:
    heard = exchange(make_medium(), {M: (b"m",), C: (b"c2", b"c1"), A: (b"a",)})

    assert heard == [(b"c2", b"c1", b"m"), (b"a", b"c2", b"c1", b"m"), (b"a", b"m"), (b"a", b"c2", b"c1")]


def test_only_linked_radios_hear() -> None:
    chain = np.zeros((4, 4), dtype=np.bool_)
    chain[0, 1] = chain[1, 0] = chain[1, 2] = chain[2, 1] = True

    heard = exchange(make_medium(), {A: (b"a",), B: (b"b",)}, links=LinkTable(chain, np.ones((4, 4))))

    assert heard == [(b"b",), (b"a",), (b"b",), ()]


def test_a_radio_that_died_in_flight_hears_nothing() -> None:
    medium = make_medium()
    medium.transmit(0, {A: (b"a",)}, ALL_LINKED)

    assert medium.collect(1, np.array([True, False, True, True])) == [(), (), (b"a",), (b"a",)]


def test_traffic_is_counted() -> None:
    traffic = make_medium().transmit(0, {A: (b"x" * 100, b"x" * 50), B: (b"x" * 20,)}, ALL_LINKED)

    assert (traffic.frames, traffic.bytes, traffic.dropped) == (3, 170, 0)
    assert traffic.peak_bps == 150 * 8 / 0.5


def test_frames_beyond_the_budget_are_dropped_and_counted() -> None:
    medium = make_medium(budget_bps=1600.0)  # 100 bytes per tick of 0.5 s

    traffic = medium.transmit(0, {A: (b"1" * 60, b"2" * 60, b"3" * 40), B: (b"x" * 100,)}, ALL_LINKED)

    assert (traffic.frames, traffic.dropped) == (3, 1)
    assert traffic.peak_bps == 1600.0
    assert medium.collect(1, ALIVE)[2] == (b"1" * 60, b"3" * 40, b"x" * 100)


def test_a_frame_longer_than_a_tick_s_allowance_is_paid_for_in_the_following_ticks() -> None:
    medium = make_medium(budget_bps=1600.0)
    sizes = [medium.transmit(tick, {A: (b"x" * 250,)}, ALL_LINKED).bytes for tick in range(7)]

    assert sizes == [250, 0, 0, 250, 0, 0, 250]  # 250 bytes take two and a half ticks


def test_unspent_budget_is_not_saved_up() -> None:
    medium = make_medium(budget_bps=1600.0)
    for tick in range(5):
        medium.transmit(tick, {}, ALL_LINKED)

    assert medium.transmit(5, {A: (b"x" * 60, b"x" * 60)}, ALL_LINKED).frames == 1


def test_loss_strikes_each_receiver_on_its_own_at_the_stated_rate() -> None:
    medium = make_medium(loss=0.3)
    heard = np.array([[len(box) for box in exchange(medium, {A: (b"a",)}, tick)] for tick in range(3000)])

    assert heard[:, 0].sum() == 0
    assert heard[:, 1:].mean(axis=0) == pytest.approx(0.7, abs=0.03)
    assert abs(np.corrcoef(heard[:, 1], heard[:, 2])[0, 1]) < 0.06


def test_total_loss_delivers_nothing() -> None:
    assert exchange(make_medium(loss=1.0), {A: (b"a",) * 50}) == [(), (), (), ()]


def test_delayed_frames_arrive_late_but_arrive_within_the_limit_each_once() -> None:
    medium = make_medium(delay_ticks_max=2)
    sent = [bytes([k]) for k in range(60)]
    medium.transmit(0, {A: sent}, ALL_LINKED)

    arrivals = [medium.collect(tick, ALIVE)[1] for tick in (1, 2, 3, 4)]

    assert all(arrivals[:3])
    assert arrivals[3] == ()
    assert sorted(frame for box in arrivals for frame in box) == sent


def test_frames_of_one_sender_that_arrive_together_keep_their_order_of_transmission() -> None:
    medium = make_medium(delay_ticks_max=1)
    medium.transmit(0, {A: [b"old-%d" % k for k in range(20)]}, ALL_LINKED)
    medium.collect(1, ALIVE)
    medium.transmit(1, {A: [b"new-%d" % k for k in range(20)], B: [b"b"] * 20}, ALL_LINKED)

    box = medium.collect(2, ALIVE)[2]

    names = [frame.split(b"-")[0] for frame in box]
    assert names == sorted(names, key=[b"old", b"new", b"b"].index)
    assert set(names) == {b"old", b"new", b"b"}


def test_one_radio_s_traffic_does_not_change_the_luck_of_another() -> None:
    quiet, busy = make_medium(loss=0.5), make_medium(loss=0.5)
    for tick in range(50):
        alone = exchange(quiet, {B: (b"b",)}, tick)
        crowded = exchange(busy, {A: (b"a", b"a"), B: (b"b",)}, tick)
        assert [b"b" in box for box in alone] == [b"b" in box for box in crowded]


def test_the_seed_decides_who_misses_what() -> None:
    frames = {A: (b"a",) * 40}

    assert exchange(make_medium(loss=0.5), frames) == exchange(make_medium(loss=0.5), frames)
    assert exchange(make_medium(loss=0.5), frames) != exchange(make_medium(loss=0.5, seed=2), frames)
