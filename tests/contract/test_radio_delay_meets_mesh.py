"""The mesh is told how late the simulated radio may deliver a hello, and the radio keeps to that."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.frames import HELLO_SIZE
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.types import NodeId
from swarm_sim.config import RadioConfig, SimConfig
from swarm_sim.radio.links import LinkTable
from swarm_sim.radio.medium import Medium, longest_delay

PAIR = LinkTable(~np.eye(2, dtype=np.bool_), np.ones((2, 2)))
HELLO = 400
"""Bytes of the hellos."""


def latest_hello(config: RadioConfig, period_s: float) -> int:
    """Return how many ticks late hellos come at worst while a radio has several times too much to say."""
    medium = Medium(config, (NodeId(0), NodeId(1)), period_s, seed=1)
    load = int(config.budget_bps / 8 * (config.queue_s + period_s)) // 8
    latest = 0
    for tick in range(60):
        heard = medium.collect(tick, np.ones(2, dtype=np.bool_))[1]
        latest = max([latest, *(tick - 1 - int(frame[:6]) for frame in heard if frame[6:7] == b"h")])
        hello = (b"%06dh" % tick).ljust(HELLO, b".")
        packets = [(b"%06dp" % tick).ljust(load + 7 * (tick % 5), b".")] * 40
        medium.transmit(tick, {NodeId(0): (hello, *packets)}, PAIR)
    return latest


@pytest.mark.parametrize("period_s", [0.5, 0.3])
@pytest.mark.parametrize("queue_s", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("delay_ticks_max", [0, 1, 3])
@pytest.mark.parametrize("budget_bps", [250_000.0, 7_001.0])
def test_no_hello_of_an_overloaded_radio_is_later_than_announced(
    period_s: float, queue_s: float, delay_ticks_max: int, budget_bps: float
) -> None:
    config = RadioConfig(queue_s=queue_s, delay_ticks_max=delay_ticks_max, budget_bps=budget_bps)
    announced = longest_delay(config, period_s, HELLO)

    assert announced - 1 <= latest_hello(config, period_s) <= announced


def test_the_default_network_bears_the_default_radio() -> None:
    sim = SimConfig()
    crowd = HELLO_SIZE + 5 * 51

    assert longest_delay(sim.radio, sim.period_s, crowd) * sim.period_s <= NetworkConfig().delay_max_s
