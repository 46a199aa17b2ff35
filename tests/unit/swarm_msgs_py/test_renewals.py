"""Where frames are lost, a renewed row is said twice if it may have been missed."""

from __future__ import annotations

import numpy as np
import pytest
from mesh_lab import MeshLab

from swarm_msgs_py.messages.radio import RouteRows
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.dsdv import RouteTable
from swarm_msgs_py.networking.labels import advert_of
from swarm_msgs_py.types import NodeId

A, B = NodeId(0), NodeId(1)
QUIET = NetworkConfig(full_dump_period_s=60.0, stale_time_s=600.0)  # no dump within these tests


def hear(table: RouteTable, neighbor: NodeId, row: tuple[int, int, int], tick: int) -> None:
    table.merge(tick, [advert_of(neighbor, RouteRows(*np.array([row], dtype=np.int64).T))])


def lossy_table(neighbors: int, passed_on_by: int) -> RouteTable:
    """Return a table with a renewed row for D = 99, said in tick 1, that some of the neighbors have passed on since."""
    table = RouteTable(A, QUIET, 1.0)
    everybody = [NodeId(n) for n in range(1, neighbors + 1)]
    for neighbor in everybody:
        hear(table, neighbor, (neighbor, 0, 100), tick=0)
    table.advertise(0, loss=0.3)
    hear(table, B, (99, 1, 100), tick=1)
    assert 99 in table.advertise(1, loss=0.3).destinations
    for neighbor in everybody[1:passed_on_by]:
        hear(table, neighbor, (99, 2, 100), tick=3)
    return table


@pytest.mark.parametrize(("neighbors", "passed_on_by", "is_repeated"), [(2, 1, 1), (2, 2, 0), (8, 2, 1), (8, 3, 0)])
def test_renewed_row_that_too_few_neighbors_pass_on_is_said_once_more_where_frames_are_lost(
    neighbors: int, passed_on_by: int, is_repeated: int
) -> None:
    table, calm = (lossy_table(neighbors, passed_on_by) for _ in range(2))

    assert sum(99 in table.advertise(tick, loss=0.3).destinations for tick in range(2, 30)) == is_repeated
    assert sum(99 in calm.advertise(tick, loss=0.0).destinations for tick in range(2, 30)) == 0


def test_row_is_said_once_more_two_ticks_later_and_again_only_under_a_new_number() -> None:
    table = lossy_table(2, 1)

    times = [tick for tick in range(2, 40) if 99 in table.advertise(tick, loss=0.3).destinations]
    hear(table, B, (99, 1, 102), tick=40)
    times += [tick for tick in range(40, 59) if 99 in table.advertise(tick, loss=0.3).destinations]

    assert times == [3, 40, 42]


def test_a_long_chain_that_loses_frames_has_nearly_always_a_route() -> None:
    """Said once only, renewed rows leave two of a hundred pairs without a route."""
    missing, pairs = 0, 0
    for seed in range(2):
        lab = MeshLab(10, tuple((n, n + 1) for n in range(9)), seed=seed, loss=0.1)
        lab.run(60)
        for _ in range(120):
            lab.run(1)
            pairs += 90
            missing += sum(9 - len(node.reachable) for node in lab.nodes.values())

    assert missing / pairs < 0.018
