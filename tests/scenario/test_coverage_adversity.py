"""Covering swarms among obstacles, with noisy sensing, over a radio that loses frames, and after the leader's death."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from coverage_swarm import BEAM, mission

from studies.coverage_mission import CoverageMission
from swarm_agent.coverage.config import Expansion, Rule
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.geometry.solids.barriers import Barriers
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.metrics.coverage import CoverageProbe
from swarm_sim.points.config import PointSimConfig, SpaceRadioConfig

PROBE = CoverageProbe(solid_from(BEAM), 50.0, seed=9, inner=20_000, outer=2_000)
LEADER = NodeId(0)
WALL = Barriers([solid_from({"kind": "box", "center_m": [30.0, 0.0, 0.0], "size_m": [4.0, 36.0, 36.0]})])


def covered(positions: FloatArray) -> float:
    return PROBE.measure(positions).covered_fraction


@pytest.mark.parametrize("expansion", [Expansion.PARALLEL, Expansion.PREDICTED])
def test_places_and_ways_go_around_a_wall(expansion: Expansion) -> None:
    swarm = mission(Rule.LAYOUT, expansion, seed=1, sigma_m=0.0, barriers=WALL)

    tracks = []
    while swarm.world.tick < 900 and not swarm.watch.is_over:
        before = swarm.world.positions.copy()
        swarm.tick()
        tracks.append((before, swarm.world.positions.copy()))

    assert swarm.watch.is_over
    assert swarm.watch.violations == 0
    assert covered(swarm.outcome().positions) >= 0.998
    assert not any(WALL.cut(before, after).any() for before, after in tracks)


def test_errors_of_localization_grow_as_the_root_of_the_depth() -> None:
    sigma = 0.3
    errors: dict[int, list[float]] = {}
    for seed in range(4):
        world = PointSimConfig(process_sigma_m=0.0, offset_sigma_m=sigma)
        swarm = mission(Rule.RANDOM, Expansion.PARALLEL, seed=seed, sigma_m=0.3, world=world)
        swarm.run(500)
        found = swarm.watch.errors(50.0, np.zeros(3))
        for depth, error in zip(found.depths.tolist(), found.localization.tolist(), strict=True):
            errors.setdefault(depth, []).append(error)

    assert max(errors[0]) == pytest.approx(0.0, abs=1e-5)
    for depth in (1, 2):
        rms = float(np.sqrt(np.mean(np.square(errors[depth]))))
        assert 0.5 * sigma * np.sqrt(3.0) <= rms <= 1.5 * sigma * np.sqrt(3.0 * depth)


def test_a_radio_that_loses_frames_delays_but_does_not_prevent() -> None:
    world = PointSimConfig(radio=SpaceRadioConfig(loss=0.1))
    swarm = mission(Rule.RANDOM, Expansion.PARALLEL, seed=2, world=world)

    outcome = swarm.run(900)

    assert outcome.is_complete
    assert outcome.rendezvous_s < 120.0  # what was lost is said again, and nobody waits for who has passed
    assert covered(outcome.positions) >= 0.998


def led_by_another(seed: int) -> tuple[CoverageMission, NodeId]:
    """Return a swarm whose leader has died after all had arrived, and who leads instead."""
    swarm = mission(seed=seed)
    swarm.run(700)
    swarm.kill([LEADER])
    swarm.run(1400)
    leaders = [robot for robot, report in swarm.watch.reports.items() if report.is_leading]
    assert len(leaders) == 1
    return swarm, leaders[0]


def test_who_takes_the_dead_leaders_place_obeys_orders() -> None:
    swarm, leader = led_by_another(4)
    upright = {"kind": "box", "size_m": [50.0, 50.0, 160.0]}

    swarm.order(shape=upright)
    outcome = swarm.run(2400)

    probe = CoverageProbe(solid_from(upright), 50.0, seed=9, inner=20_000, outer=2_000)
    assert leader != LEADER
    assert outcome.is_complete
    assert swarm.watch.reports[leader].is_leading
    assert probe.measure(outcome.positions).covered_fraction >= 0.998


def test_robots_that_die_while_waiting_or_under_way_leave_no_hole() -> None:
    swarm = mission(Rule.GAIN, Expansion.PARALLEL, seed=5)
    while list(swarm.modes.values()).count(CoverageMode.HOLDING) < 3:
        swarm.tick()
    by_mode = {mode: max((r for r, m in swarm.modes.items() if m is mode), default=None) for mode in CoverageMode}
    victims = [by_mode[mode] for mode in (CoverageMode.WAITING, CoverageMode.TRAVELING)]

    swarm.kill([robot for robot in victims if robot is not None])
    outcome = swarm.run(900)

    assert outcome.is_complete
    assert covered(outcome.positions) >= 0.998


@pytest.mark.parametrize(
    ("rule", "expansion", "seed"),
    [
        (Rule.LAYOUT, Expansion.PREDICTED, 7),
        (Rule.GAIN, Expansion.PARALLEL, 12),
        (Rule.RANDOM, Expansion.PARALLEL, 1),
    ],
)
def test_robots_that_die_at_any_moment_leave_one_swarm_without_a_hole(
    rule: Rule, expansion: Expansion, seed: int
) -> None:
    swarm, until = mission(rule, expansion, seed=seed, robots=40), 90
    rng = np.random.default_rng(seed)
    victims, ticks = rng.choice(np.arange(1, 40), 18, replace=False), rng.integers(2, until, 18)

    while swarm.world.tick < 700 and not (swarm.watch.is_over and swarm.world.tick > until):
        if (ticks == swarm.world.tick).any():
            swarm.kill(victims[ticks == swarm.world.tick].tolist())
        swarm.tick()

    assert swarm.watch.is_over
    assert swarm.watch.components == 1
    assert covered(swarm.outcome().positions) >= 0.998


def test_what_is_no_frame_is_dropped() -> None:
    swarm = mission(seed=3)
    seen = swarm.world.observe().agents[LEADER]

    outputs = swarm.agents[LEADER].step(replace(seen, inbox=(b"", b"\x81", b"\x01\x02", bytes(40))))

    assert outputs.report.mode is CoverageMode.GATHERING


def test_robots_at_rest_that_drift_keep_station() -> None:
    sigma, rest = 1.0, 100
    swarm = mission(seed=6, robots=14, sigma_m=sigma, world=PointSimConfig(process_sigma_m=sigma, drifts=True))
    swarm.run(700)
    assert swarm.watch.is_over

    for _ in range(rest):
        swarm.tick()

    off = swarm.watch.errors(50.0, np.zeros(3)).placement
    assert swarm.watch.violations == 0
    assert np.sqrt(np.mean(off**2)) < 0.5 * sigma * np.sqrt(3.0 * rest)  # of robots that only drifted
    assert covered(swarm.outcome().positions) >= 0.99
