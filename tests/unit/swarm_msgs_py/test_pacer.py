from __future__ import annotations

import pytest

from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.pacer import Pacer

PERIOD_S = 0.5
CHANNEL = NetworkConfig(paced_bps=16_000.0)  # 1000 bytes per tick


def sent(pacer: Pacer, ticks: int, size: int, sharers: int = 1, first: int = 0) -> list[int]:
    """Return the bytes of each tick when packets of `size` bytes always wait."""
    sizes = []
    for tick in range(first, first + ticks):
        pacer.fill(tick, sharers)
        sizes.append(0)
        while pacer.is_open:
            pacer.spend(size)
            sizes[-1] += size
    return sizes


def test_a_radio_alone_has_the_whole_channel() -> None:
    assert sent(Pacer(CHANNEL, PERIOD_S), 5, 100) == [1000] * 5


@pytest.mark.parametrize("sharers", [2, 10, 51])
def test_radios_that_share_a_channel_stay_below_it_together(sharers: int) -> None:
    ticks = 100
    total = sharers * sum(sent(Pacer(CHANNEL, PERIOD_S), ticks, 60, sharers))

    assert 0.98 * ticks * 1000 < total <= ticks * 1000 + sharers * 60


def test_a_packet_longer_than_the_share_goes_and_is_paid_for_afterwards() -> None:
    sizes = sent(Pacer(CHANNEL, PERIOD_S), 100, 250, sharers=10)  # 100 bytes per tick

    assert set(sizes) == {0, 250}
    assert sum(sizes) == pytest.approx(100 * 100, abs=250)


def test_silence_is_not_saved_up_beyond_a_burst() -> None:
    pacer = Pacer(CHANNEL, PERIOD_S)
    sent(pacer, 1, 100)

    assert sent(pacer, 2, 100, first=1000) == [1000, 1000]


def test_a_huge_packet_silences_its_radio_for_some_seconds_only() -> None:
    pacer = Pacer(CHANNEL, PERIOD_S)
    pacer.fill(0, 10)
    pacer.spend(65_000)

    assert sent(pacer, 12, 50, sharers=10, first=1).index(100) == 10


def test_short_ticks_have_the_same_rate() -> None:
    assert sum(sent(Pacer(CHANNEL, 0.05), 200, 10)) == pytest.approx(20_000 + 900, abs=10)
