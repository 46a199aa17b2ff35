"""Whole missions of message-level robots: they cover, stay linked at every tick, and mend what is lost."""

from __future__ import annotations

import numpy as np
import pytest
from coverage_swarm import BEAM, mission

from studies.coverage_mission import CoverageMission
from swarm_agent.coverage.config import Expansion, Rule
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.coverage import CoverageProbe

PROBE = CoverageProbe(solid_from(BEAM), 50.0, seed=9, inner=20_000, outer=2_000)
CASES = [
    (Rule.LAYOUT, Expansion.PREDICTED, 1.0),
    (Rule.LAYOUT, Expansion.SERIAL, 0.0),
    (Rule.GAIN, Expansion.PARALLEL, 1.0),
    (Rule.RANDOM, Expansion.SERIAL, 1.0),
]


def covered(swarm: CoverageMission) -> float:
    return PROBE.measure(swarm.outcome().positions).covered_fraction


@pytest.mark.parametrize(("rule", "expansion", "sigma_m"), CASES)
def test_a_swarm_covers_its_shape_and_is_linked_at_every_tick(rule: Rule, expansion: Expansion, sigma_m: float) -> None:
    swarm = mission(rule, expansion, sigma_m=sigma_m)

    outcome = swarm.run(700)

    assert outcome.is_complete
    assert outcome.violations == 0
    assert covered(swarm) >= 0.998
    assert 2 <= outcome.placed <= 14


def test_a_layout_in_parallel_is_faster_than_one_robot_at_a_time() -> None:
    together, apart = (mission(expansion=e, seed=3).run(700) for e in (Expansion.PREDICTED, Expansion.SERIAL))

    assert together.expansion_s < apart.expansion_s
    assert together.placed == apart.placed


def test_equal_seeds_give_equal_missions() -> None:
    first, second = (mission(seed=5).run(60) for _ in range(2))

    assert first.positions.tobytes() == second.positions.tobytes()
    assert (first.frames, first.frame_bytes) == (second.frames, second.frame_bytes)


@pytest.mark.parametrize("rule", [Rule.LAYOUT, Rule.GAIN])
def test_places_of_robots_that_die_are_filled_again(rule: Rule) -> None:
    swarm = mission(rule, Expansion.PARALLEL, seed=6)
    swarm.run(700)
    placed = [r for r, mode in sorted(swarm.modes.items()) if mode is CoverageMode.HOLDING and r != 0]

    swarm.kill(placed[:1])
    outcome = swarm.run(1400)

    assert outcome.is_complete
    assert covered(swarm) >= 0.998
    assert swarm.watch.components == 1


def test_the_place_of_a_robot_that_dies_on_the_way_is_given_to_another() -> None:
    swarm = mission(seed=7)
    while CoverageMode.TRAVELING not in swarm.modes.values():
        swarm.tick()
    for _ in range(3):
        swarm.tick()
    victim = max(robot for robot, mode in swarm.modes.items() if mode is CoverageMode.TRAVELING)
    swarm.kill([NodeId(victim)])

    outcome = swarm.run(700)

    assert outcome.is_complete
    assert covered(swarm) >= 0.998


def test_a_leader_outside_the_shape_leads_the_swarm_to_it() -> None:
    far = {"kind": "moved", "of": BEAM, "offset_m": [150.0, 0.0, 0.0]}
    swarm = mission(shape=far, sigma_m=0.0)

    outcome = swarm.run(700)

    assert outcome.is_complete
    assert outcome.approach_s > 10.0
    assert outcome.violations == 0
    assert np.linalg.norm(outcome.positions - np.array([150.0, 0.0, 0.0]), axis=1).min() < 40.0


def test_robots_that_appear_fill_the_holes_for_which_there_were_none() -> None:
    long = {"kind": "box", "size_m": [300.0, 50.0, 50.0]}
    probe = CoverageProbe(solid_from(long), 50.0, seed=9, inner=20_000, outer=2_000)
    newcomers = 20.0 * rng_for(0, "newcomers").random((6, 3))
    swarm = mission(shape=long, robots=4, seed=1, sigma_m=0.0, newcomers=newcomers, appear_at=150)
    early = swarm.run(150)

    late = swarm.run(500)

    assert not early.is_complete
    assert probe.measure(early.positions).covered_fraction < 0.9
    assert late.is_complete
    assert probe.measure(late.positions).covered_fraction >= 0.998


def test_a_new_shape_is_covered_after_a_rendezvous() -> None:
    swarm = mission(seed=2)
    swarm.run(400)
    upright = {"kind": "box", "size_m": [50.0, 50.0, 160.0]}

    swarm.order(shape=upright)
    outcome = swarm.run(900)

    probe = CoverageProbe(solid_from(upright), 50.0, seed=9, inner=20_000, outer=2_000)
    assert outcome.is_complete
    assert outcome.violations == 0
    assert probe.measure(outcome.positions).covered_fraction >= 0.998


def test_a_formation_that_moves_keeps_its_shape() -> None:
    swarm = mission(seed=3)
    swarm.run(400)
    start = swarm.outcome().positions

    swarm.order(velocity=(1.0, 0.5, 0.0))
    for _ in range(120):
        swarm.tick()

    moved = swarm.outcome().positions - start
    expected = (120 - 20) * np.array([1.0, 0.5, 0.0])  # it sets out when all have heard
    assert swarm.watch.violations == 0
    assert np.linalg.norm(moved - expected, axis=1).max() < 8.0


def test_the_mission_goes_on_after_the_leader_has_died() -> None:
    swarm = mission(seed=4)
    while sum(mode is CoverageMode.HOLDING for mode in swarm.modes.values()) < 3:
        swarm.tick()

    swarm.kill([NodeId(0)])
    outcome = swarm.run(700)

    assert outcome.is_complete
    assert covered(swarm) >= 0.998
