"""Packets are remembered for as long as copies of them can be on their way, and numbered so that this suffices."""

from __future__ import annotations

import pytest
from mesh_lab import PERIOD_S, MeshLab

from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.lifetimes import PacketMemory, PacketNumbers, lifetime_ticks_max, stay_ticks_max

CYCLE = 4096
"""Ticks after which numbers come again."""


def test_a_packet_is_forgotten_when_no_hop_can_hold_it_any_more() -> None:
    config = NetworkConfig(hop_limit=2, hold_time_s=2.0, attempts=3, acknowledge_time_s=1.0, delay_max_s=0.5)
    assert stay_ticks_max(config, PERIOD_S) == 4 + 3 * (2 + 2)
    assert lifetime_ticks_max(config, PERIOD_S) == 2 * (16 + 1 + 1)
    memory = PacketMemory(config, PERIOD_S)

    assert memory.add(10, "packet")
    memory.expire(46)
    assert not memory.add(46, "packet")
    memory.expire(47)
    assert memory.add(47, "packet")


@pytest.mark.parametrize("hold_time_s", [8.0, 600.0])
def test_packets_are_forgotten_before_their_numbers_come_again(hold_time_s: float) -> None:
    assert lifetime_ticks_max(NetworkConfig(hold_time_s=hold_time_s), PERIOD_S) < CYCLE


def test_equal_numbers_are_a_cycle_apart_also_over_a_restart() -> None:
    made: dict[int, int] = {}
    for life in (0, 700, CYCLE, CYCLE + 1900):
        numbers = PacketNumbers()
        for tick in range(life, life + 600):
            for _ in range(tick % 7 * 4):  # up to 24 in a tick, 12 on average
                number = numbers.take(tick)
                assert 0 <= number < 1 << 16
                assert tick - made.get(number, -CYCLE) >= CYCLE - 2
                made[number] = tick


@pytest.mark.parametrize("restart", [30, 500, 1700, 4000, 4096, 4100, 8192, 3 * 4096])
def test_floods_of_a_node_that_restarts_at_any_time_are_not_taken_for_old_ones(restart: int) -> None:
    lab = MeshLab(2, ((0, 1),))
    for life in (0, restart):
        lab.tick = life
        for tick in range(life, life + 25):
            lab.receive()
            lab.nodes[0].flood(b"%d" % tick)
            lab.transmit()
        lab.join(0)

    bodies = [int(delivery.body) for _, delivery in lab.deliveries[1]]
    assert len(set(bodies)) == len(bodies)
    assert set(bodies) >= {*range(20), *range(restart, restart + 20)}
