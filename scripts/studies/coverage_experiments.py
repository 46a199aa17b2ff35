"""The coverage paper's experiments E1 to E4, many seeds each, as one table row per method (spec section 11)."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bringup.coverage.starts import LEADER
from studies.coverage_mission import CoverageMission, CoverageOutcome
from swarm_agent.coverage.config import CoverageConfig, Expansion, MotionConfig, Rule
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.coverage import CoverageProbe
from swarm_sim.points.config import PointSimConfig, SpaceRadioConfig

EDGE = 200.0 / 3.0  # 66.7 m
BEAM = {"kind": "box", "size_m": [300.0, EDGE, EDGE]}
EXPERIMENTS: dict[str, tuple[dict[str, Any], float]] = {
    "ball": ({"kind": "ball", "radius_m": 100.0}, 50.0),
    "ball70": ({"kind": "ball", "radius_m": 100.0}, 70.0),
    "box": (BEAM, 50.0),
    "cross": ({"kind": "union", "of": [BEAM, {"kind": "box", "size_m": [EDGE, EDGE, 200.0]}]}, 50.0),
}
"""Shape and r_sc [m] of each."""

EXACT, NOISY = 0.95, 0.90  # placement without and with process noise [I13]
TICKS_MAX = 3000
HEADER = "experiment  rule    expansion  seeds done robots       rendezvous  expansion      lost links  covered  wall"


@dataclass(frozen=True, slots=True)
class Trial:
    """One mission's outcome and measures.

    Attributes
    ----------
    outcome : CoverageOutcome
    covered : float
        Share of the volume.
    wall_s : float
        [s].
    """

    outcome: CoverageOutcome
    covered: float
    wall_s: float


def settings_of(name: str, rule: Rule, expansion: Expansion, sigma: float) -> tuple[CoverageConfig, PointSimConfig]:
    """Return the settings of agents and world for one experiment with process noise `sigma` [m]."""
    _, radius = EXPERIMENTS[name]
    agents = CoverageConfig(
        range_m=radius,
        rule=rule,
        expansion=expansion,
        placement=NOISY if sigma > 0.0 else EXACT,
        motion=replace(MotionConfig(), sigma_m=sigma),
    )
    radio = SpaceRadioConfig(range_m=radius)
    return agents, PointSimConfig(radio=radio, sight_m=2.0 * radius, process_sigma_m=sigma)


def trials(arguments: argparse.Namespace, name: str) -> Iterator[Trial]:
    """Yield one trial per seed; with `--kill`, that share of the placed followers dies once the shape is covered."""
    shape, radius = EXPERIMENTS[name]
    agents, world = settings_of(name, Rule(arguments.rule), Expansion(arguments.expansion), arguments.sigma)
    probe = CoverageProbe(solid_from(shape), radius, seed=0)
    for seed in range(arguments.seeds):
        start = time.perf_counter()
        mission = CoverageMission(shape, agents, world, arguments.robots, seed)
        outcome = mission.run(TICKS_MAX)
        if arguments.kill:
            placed = [r for r, m in sorted(mission.modes.items()) if m is CoverageMode.HOLDING and r != LEADER]
            count = round(arguments.kill * len(placed))
            mission.kill(rng_for(seed, "coverage", "kill").choice(placed, count, replace=False).tolist())
            outcome = mission.run(2 * TICKS_MAX)
        wall = time.perf_counter() - start
        yield Trial(outcome, probe.measure(outcome.positions).covered_fraction, wall)


def row(name: str, arguments: argparse.Namespace, done: Sequence[Trial]) -> str:
    """Return the line of the table for all trials of one experiment."""
    robots = np.array([trial.outcome.placed for trial in done])
    expansion = np.array([trial.outcome.expansion_s for trial in done])
    return (
        f"{name:11s} {arguments.rule:7s} {arguments.expansion:10s} {len(done):5d}"
        f" {sum(trial.outcome.is_complete for trial in done):4d}"
        f" {robots.mean():5.2f} ({robots.min()}-{robots.max()})"
        f"  {max(trial.outcome.rendezvous_s for trial in done):5.0f} s max"
        f"  {expansion.mean():4.0f} s, {expansion.max():4.0f} max"
        f"  {sum(trial.outcome.violations for trial in done):5d}"
        f"    {np.mean([trial.covered for trial in done]):.5f}"
        f"  {np.mean([trial.wall_s for trial in done]):.1f} s, {max(trial.wall_s for trial in done):.1f} max"
    )


def main(words: Sequence[str] | None = None) -> int:
    """Run what the command line asks for, and print the table; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--experiment", nargs="+", choices=sorted(EXPERIMENTS), default=sorted(EXPERIMENTS))
    parser.add_argument("--rule", choices=[rule.value for rule in Rule], default=Rule.LAYOUT.value)
    parser.add_argument("--expansion", choices=[e.value for e in Expansion], default=Expansion.PREDICTED.value)
    parser.add_argument("--sigma", type=float, default=1.0, help="process noise per step and axis [m]")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--robots", type=int, default=100, help="the leader included")
    parser.add_argument("--kill", type=float, default=0.0, help="share of the placed followers that die")
    arguments = parser.parse_args(words)
    print(HEADER)
    for name in arguments.experiment:
        print(row(name, arguments, list(trials(arguments, name))), flush=True)
    return 0
