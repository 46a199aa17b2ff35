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


def arrivals(medium: Medium, outboxes: Sequence[Outboxes], ticks: int, radio: int = 1) -> list[tuple[bytes, ...]]:
    """Return what one radio hears tick by tick, while the outboxes are handed over one per tick, then none."""
    heard = []
    for tick in range(ticks):
        medium.transmit(tick, outboxes[tick] if tick < len(outboxes) else {}, ALL_LINKED)
        heard.append(medium.collect(tick + 1, ALIVE)[radio])
    return heard


def test_what_a_tick_has_no_time_for_goes_on_in_the_next_in_order() -> None:
    medium = make_medium(budget_bps=1600.0)  # 100 bytes per tick of 0.5 s
    first, second, third, later = b"1" * 60, b"2" * 60, b"3" * 40, b"4" * 50

    heard = arrivals(medium, [{A: (first, second, third)}, {A: (later,)}], 4)

    assert heard == [(first,), (second, third), (later,), ()]  # 60; 40 + 20 and 40 of 160; 10 and 40 of the last


def test_a_frame_longer_than_a_tick_gets_through_behind_a_hello_in_every_tick() -> None:
    medium = make_medium(budget_bps=1600.0)
    hello, plan = b"h" * 40, b"p" * 250

    heard = arrivals(medium, [{A: (hello, plan)}, *[{A: (hello,)}] * 20], 30)

    assert heard[:3] == [(hello,), (), (plan,)]  # 290 bytes take three ticks
    assert sum(frames.count(hello) for frames in heard) == 21
    assert all(len(b"".join(frames)) <= 350 for frames in heard)


def test_a_frame_is_heard_by_whom_the_sender_reaches_when_it_is_complete() -> None:
    medium = make_medium(budget_bps=1600.0)
    nobody = LinkTable(np.zeros((4, 4), dtype=np.bool_), np.ones((4, 4)))
    medium.transmit(0, {A: (b"x" * 150,)}, nobody)

    assert medium.collect(1, ALIVE) == [(), (), (), ()]
    medium.transmit(1, {}, ALL_LINKED)
    assert medium.collect(2, ALIVE) == [(), (b"x" * 150,), (b"x" * 150,), (b"x" * 150,)]


def test_bytes_and_peak_tell_what_was_on_the_air_in_each_tick() -> None:
    medium = make_medium(budget_bps=1600.0)
    traffic = [medium.transmit(tick, {A: (b"x" * 250,)} if tick == 0 else {}, ALL_LINKED) for tick in range(4)]

    assert [t.bytes for t in traffic] == [100, 100, 50, 0]
    assert [t.frames for t in traffic] == [0, 0, 1, 0]
    assert [t.peak_bps for t in traffic] == [1600.0, 1600.0, 800.0, 0.0]


def test_a_rate_of_no_whole_number_of_bytes_per_tick_is_kept_on_average() -> None:
    medium = make_medium(budget_bps=100.0, queue_s=60.0)  # 6.25 bytes per tick
    sizes = [medium.transmit(tick, {A: (b"x" * 10,)}, ALL_LINKED).bytes for tick in range(40)]

    assert sum(sizes) == 250
    assert set(sizes) == {6, 7}


def test_frames_that_would_wait_too_long_are_dropped_and_counted_once() -> None:
    medium = make_medium(budget_bps=1600.0, queue_s=1.0)  # 100 bytes per tick; 200 may wait at its end
    sent = [bytes([k]) * 60 for k in range(20)]

    dropped: list[int] = []
    heard: list[bytes] = []
    for tick in range(6):
        dropped.append(medium.transmit(tick, {A: sent} if tick == 0 else {}, ALL_LINKED).dropped)
        heard += medium.collect(tick + 1, ALIVE)[1]

    assert heard == sent[:6]  # 300 bytes stand before the sixth, 360 would stand before the seventh
    assert dropped == [14, 0, 0, 0, 0, 0]


def test_an_overloaded_radio_keeps_its_rate_and_never_lags_more_than_the_queue() -> None:
    medium = make_medium(budget_bps=1600.0, queue_s=1.0)
    lags, sizes = [], []
    for tick in range(50):
        sizes.append(medium.transmit(tick, {A: [bytes([tick]) * 70] * 3}, ALL_LINKED).bytes)
        lags += [tick - frame[0] for frame in medium.collect(tick + 1, ALIVE)[1]]

    assert set(sizes) == {100}
    assert max(lags) <= 3


def test_a_radio_that_died_does_not_finish_what_it_began() -> None:
    medium = make_medium(budget_bps=1600.0)
    medium.transmit(0, {A: (b"x" * 150, b"y"), B: (b"z" * 150,)}, ALL_LINKED)
    medium.collect(1, ALIVE)

    medium.silence(A)
    traffic = medium.transmit(1, {}, ALL_LINKED)

    assert (traffic.frames, traffic.bytes, traffic.dropped) == (1, 50, 2)
    assert medium.collect(2, ALIVE)[2] == (b"z" * 150,)


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
