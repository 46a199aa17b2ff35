"""Robots that a covered shape can do without are found, all at once, and never one too many."""

from __future__ import annotations

import itertools

import numpy as np
from coverage_swarm import BEAM, mission
from scipy.sparse.csgraph import connected_components

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig, Expansion, Rule
from swarm_agent.coverage.frames import Key, Place, State
from swarm_agent.coverage.release import Release, needless
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.geometry.solids.sampling import interior_points
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.metrics.coverage import CoverageProbe

CONFIG = CoverageConfig(rule=Rule.GAIN, expansion=Expansion.PARALLEL, sample_count=100)
ROD = solid_from({"kind": "box", "size_m": [150.0, 8.0, 8.0]})
ROOT: Key = (NodeId(0), 0)
LINK = 45.0


def held(*along: float) -> tuple[Place, ...]:
    return tuple(Place((NodeId(0), n), 0, State.HELD, NodeId(n), (x, 0.0, 0.0)) for n, x in enumerate(along))


def spared(places: tuple[Place, ...], link: float = LINK) -> list[int]:
    return sorted(number for _, number in needless(places, ROOT, ROD, CONFIG, link))


def test_a_robot_between_others_that_cover_and_link_without_it_can_go() -> None:
    assert spared(held(0.0, 40.0, -40.0, 20.0)) == [3]
    assert spared(held(0.0, 40.0, -40.0)) == []


def test_who_links_the_others_stays() -> None:
    assert spared(held(0.0, 50.0, -40.0, 25.0)) == []
    assert spared(held(0.0, 50.0, -40.0, 25.0), link=51.0) == [3]


def test_of_two_that_replace_each_other_one_goes() -> None:
    assert spared(held(0.0, 40.0, -40.0, 41.0)) in ([1], [3])


def test_the_leader_stays_and_nobody_goes_from_a_swarm_in_parts() -> None:
    assert spared(held(0.0, 40.0, -40.0, 0.0)) == [3]
    assert spared(held(0.0, 40.0, -40.0, 0.0, 150.0)) == []


def test_what_goes_from_a_crowd_leaves_the_shape_covered_and_the_rest_linked() -> None:
    solid, rng = solid_from(BEAM), np.random.default_rng(1)
    config = CoverageConfig(rule=Rule.GAIN)
    points: FloatArray = np.concatenate([np.zeros((1, 3)), interior_points(solid, 15, rng)])
    places = tuple(Place((NodeId(0), n), 0, State.HELD, NodeId(n), tuple(p)) for n, p in enumerate(points.tolist()))

    gone = needless(places, ROOT, solid, config, LINK)

    stay = np.array([place.position for place in places if place.key not in gone])
    links = np.linalg.norm(stay[:, None] - stay, axis=2) <= LINK
    probe = CoverageProbe(solid, 50.0, seed=3, inner=20_000, outer=2_000)
    before, after = (probe.measure(swarm).covered_fraction for swarm in (points, stay))
    assert len(gone) >= 4
    assert connected_components(links, directed=False, return_labels=False) == 1
    assert after >= before - 2e-4


def test_a_robot_waits_until_everybody_can_know_the_same() -> None:
    board = Board(LINK)
    for place in held(0.0, 40.0, -40.0, 20.0):
        board.merge(place)
    release = Release((NodeId(0), 3), ROOT, ROD, CONFIG)

    due = [tick for tick in range(60) if release.is_due(tick, board)]
    assert due == [2 * 1 + CONFIG.protocol.heartbeat_ticks + CONFIG.protocol.quiet_ticks]
    assert release.is_decided

    board.merge(Place((NodeId(1), 1), 0, State.OPEN, NodeId(0xFFFF), (60.0, 0.0, 0.0)))
    assert not any(release.is_due(tick, board) for tick in range(60, 120))
    assert not release.is_decided


def test_released_robots_come_back_linked_and_the_shape_stays_covered() -> None:
    shape = {"kind": "ball", "radius_m": 90.0}
    swarm, most = mission(Rule.GAIN, Expansion.PARALLEL, shape=shape, robots=45, seed=1), 0
    while swarm.world.tick < 900 and not swarm.watch.is_over:
        swarm.tick()
        most = max(most, len(swarm.watch.holders))

    outcome = swarm.outcome()
    waiting = [r for r in swarm.agents if r not in swarm.watch.holders]
    away = np.linalg.norm(swarm.world.positions[waiting] - swarm.world.positions[0], axis=1)
    probe = CoverageProbe(solid_from(shape), 50.0, seed=9, inner=20_000, outer=2_000)
    assert outcome.is_complete
    assert outcome.placed + 1 < most
    assert swarm.watch.violations == 0
    assert away.max() <= 45.0
    assert probe.measure(outcome.positions).covered_fraction >= 0.998
    for first, second in itertools.pairwise(sorted(swarm.agents)):
        assert swarm.agents[first]._board.digest == swarm.agents[second]._board.digest
