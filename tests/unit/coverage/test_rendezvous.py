"""Rendezvous: hop numbers are those of breadth-first search, everybody comes, nobody is lost on the way."""

from __future__ import annotations

import numpy as np
import pytest
from coverage_swarm import mission
from scipy.sparse.csgraph import dijkstra

from swarm_msgs_py.coverage_io import CoverageMode

LINK = 0.98 * 50.0


def hops_of(positions: np.ndarray) -> np.ndarray:
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    return dijkstra((distances <= LINK).astype(float), unweighted=True, indices=0)


@pytest.mark.parametrize("seed", range(3))
def test_hop_numbers_are_least_and_each_robot_searches_once(seed: int) -> None:
    swarm = mission(seed=seed, sigma_m=0.0)
    expected = hops_of(swarm.world.positions)

    for _ in range(6):
        swarm.tick()

    reports = [swarm.watch.reports[robot] for robot in sorted(swarm.agents)]
    assert [report.hops for report in reports] == expected.astype(int).tolist()
    assert [report.searches for report in reports] == [1] * len(reports)


@pytest.mark.parametrize(("sigma_m", "seed"), [(0.0, 1), (1.0, 2)])
def test_all_robots_come_to_the_leader_and_stay_linked(sigma_m: float, seed: int) -> None:
    swarm = mission(seed=seed, sigma_m=sigma_m)

    while swarm.modes.get(0) is not CoverageMode.WAITING and swarm.world.tick < 120:
        swarm.tick()

    assert swarm.world.tick < 60
    assert CoverageMode.GATHERING not in swarm.modes.values()
    assert swarm.watch.violations == 0
    assert np.linalg.norm(swarm.world.positions - swarm.world.positions[0], axis=1).max() <= 4.0


def test_leaves_move_first() -> None:
    swarm = mission(seed=4, sigma_m=0.0)
    start = swarm.world.positions.copy()
    while (swarm.world.positions == start).all():
        swarm.tick()

    moved = np.flatnonzero((swarm.world.positions != start).any(axis=1))
    parents = {swarm.agents[robot]._rendezvous.parent for robot in swarm.agents}
    assert not parents & set(moved.tolist())
