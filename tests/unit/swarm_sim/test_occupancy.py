from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.config import RadioConfig
from swarm_sim.radio.links import LinkTable
from swarm_sim.radio.medium import Medium
from swarm_sim.radio.occupancy import ChannelOccupancy

RADIOS = (NodeId(0), NodeId(1), NodeId(2), MISSION)
A, B, C, M = RADIOS


def chain(radios: int = 4) -> np.ndarray:
    """Return who hears whom in a row of radios: each its one or two neighbors."""
    return np.eye(radios, k=1, dtype=np.bool_) | np.eye(radios, k=-1, dtype=np.bool_)


def test_a_radio_s_channel_carries_what_it_sends_and_what_it_hears_and_nothing_else() -> None:
    rates = ChannelOccupancy(4, 1.0).note(0, np.array([100, 10, 1, 1000]), chain())

    assert rates.tolist() == [8.0 * n for n in (100 + 10, 100 + 10 + 1, 10 + 1 + 1000, 1 + 1000)]


def test_the_rate_is_that_of_a_whole_second_however_short_the_tick() -> None:
    occupancy = ChannelOccupancy(1, 0.25)
    alone = np.zeros((1, 1), dtype=np.bool_)

    rates = [occupancy.note(tick, np.array([sent]), alone)[0] for tick, sent in enumerate([100, 0, 0, 50, 0, 0, 0, 0])]

    assert rates == [800.0, 800.0, 800.0, 1200.0, 400.0, 400.0, 400.0, 0.0]


@pytest.mark.parametrize(("period_s", "ticks"), [(0.05, 20), (0.1, 10), (0.4, 3), (0.5, 2), (1.0, 1), (2.0, 1)])
def test_constant_traffic_has_its_own_rate_at_every_period(period_s: float, ticks: int) -> None:
    occupancy = ChannelOccupancy(1, period_s)
    alone = np.zeros((1, 1), dtype=np.bool_)

    rates = [occupancy.note(tick, np.array([10]), alone)[0] for tick in range(2 * ticks)]

    assert rates[ticks - 1 :] == pytest.approx([80.0 / period_s] * (ticks + 1))
    assert all(rate < 79.9 / period_s for rate in rates[: ticks - 1])


def test_what_was_heard_counts_where_it_was_heard_although_the_radios_have_parted_since() -> None:
    occupancy = ChannelOccupancy(2, 0.5)
    occupancy.note(0, np.array([100, 0]), ~np.eye(2, dtype=np.bool_))

    rates = occupancy.note(1, np.array([50, 0]), np.zeros((2, 2), dtype=np.bool_))

    assert rates.tolist() == [1200.0, 800.0]


def test_the_medium_tells_the_busiest_neighborhood_by_what_was_on_the_air_and_not_by_what_got_through() -> None:
    medium = Medium(RadioConfig(budget_bps=1600.0, loss=1.0), RADIOS, 0.5, 1)  # 100 bytes per tick
    links = LinkTable(chain(), np.ones((4, 4)))

    traffic = [
        medium.transmit(tick, {A: (b"a" * 150,), B: (b"b" * 20,), M: (b"m" * 30,)} if tick == 0 else {}, links)
        for tick in range(4)
    ]

    # A sends 100 bytes, then 50; of B's second are A's and its own, of C's those of B and of the mission computer.
    assert [t.neighborhood_bps for t in traffic] == [8.0 * n for n in (120, 170, 50, 0)]
    assert traffic[0].peak_bps == 1600.0
