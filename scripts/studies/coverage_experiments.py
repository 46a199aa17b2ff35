"""The coverage paper's experiments E1 to E4, many seeds each, as one table row per method (spec section 11)."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bringup.coverage.starts import LEADER
from studies.coverage_growth import GROWTH_HEADER, growth
from studies.coverage_mission import CoverageMission, CoverageOutcome
from swarm_agent.coverage.config import CoverageConfig, Expansion, MotionConfig, Rule
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.coverage import CoverageProbe
from swarm_sim.metrics.covering import CoveringErrors
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
    errors : CoveringErrors
        Of placement and localization.
    components : int
        Pieces at the end.
    spares : int
        Robots that hold a place at the end and did not before others died.
    killed : int
    """

    outcome: CoverageOutcome
    covered: float
    wall_s: float
    errors: CoveringErrors
    components: int
    spares: int = 0
    killed: int = 0


def settings_of(
    name: str, rule: Rule, expansion: Expansion, sigma: float, offset_sigma: float = 0.0
) -> tuple[CoverageConfig, PointSimConfig]:
    """Return the settings of agents and world for one experiment with noise of motion and of sensing [m]."""
    _, radius = EXPERIMENTS[name]
    agents = CoverageConfig(
        range_m=radius,
        rule=rule,
        expansion=expansion,
        placement=NOISY if sigma > 0.0 else EXACT,
        motion=replace(MotionConfig(), sigma_m=sigma),
    )
    radio = SpaceRadioConfig(range_m=radius)
    world = PointSimConfig(radio=radio, sight_m=2.0 * radius, process_sigma_m=sigma, offset_sigma_m=offset_sigma)
    return agents, world


def trials(arguments: argparse.Namespace, name: str) -> Iterator[Trial]:
    """Yield one trial per seed; with `--kill`, that share of the placed followers dies once the shape is covered."""
    shape, radius = EXPERIMENTS[name]
    rule, expansion = Rule(arguments.rule), Expansion(arguments.expansion)
    agents, world = settings_of(name, rule, expansion, arguments.sigma, arguments.offset_sigma)
    probe = CoverageProbe(solid_from(shape), radius, seed=0)
    for seed in range(arguments.seeds):
        start = time.perf_counter()
        mission = CoverageMission(shape, agents, world, arguments.robots, seed)
        outcome = mission.run(TICKS_MAX)
        before, count = set(mission.watch.holders), 0
        if arguments.kill:
            placed = sorted(before - {LEADER})
            count = round(arguments.kill * len(placed))
            mission.kill(rng_for(seed, "coverage", "kill").choice(placed, count, replace=False).tolist())
            outcome = mission.run(2 * TICKS_MAX)
        wall = time.perf_counter() - start
        yield Trial(
            outcome,
            probe.measure(outcome.positions).covered_fraction,
            wall,
            mission.watch.errors(radius, np.zeros(3)),
            mission.watch.components,
            len(set(mission.watch.holders) - before),
            count,
        )


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


def repair(done: Sequence[Trial]) -> str:
    """Return the line on what losses cost."""
    spares = np.array([trial.spares / trial.killed for trial in done if trial.killed])
    least = min(trial.covered for trial in done)
    return (
        f"            {sum(trial.killed for trial in done)} robots killed, {spares.mean():.2f} spare robots for each"
        f" ({spares.max():.2f} max), covered {least:.5f} min, {max(t.components for t in done)} component(s) at most"
    )


def depths(done: Sequence[Trial], sigma: float) -> str:
    """Return the line on errors of localization by depth, against noise of sensing that adds up along the chain."""
    depth = np.concatenate([trial.errors.depths for trial in done])
    error = np.concatenate([trial.errors.localization for trial in done])
    found = [
        f"{h}: {np.sqrt(np.mean(error[depth == h] ** 2)):.3f} ({sigma * np.sqrt(3.0 * h):.3f})"
        for h in range(1, int(depth.max()) + 1)
    ]
    return f"            rms error of localization by depth, theory in brackets [m]  {'  '.join(found)}"


def parsed(words: Sequence[str] | None = None) -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--experiment", nargs="+", choices=sorted(EXPERIMENTS), default=sorted(EXPERIMENTS))
    parser.add_argument("--rule", choices=[rule.value for rule in Rule], default=Rule.LAYOUT.value)
    parser.add_argument("--expansion", choices=[e.value for e in Expansion], default=Expansion.PREDICTED.value)
    parser.add_argument("--sigma", type=float, default=1.0, help="process noise per step and axis [m]")
    parser.add_argument("--offset-sigma", type=float, default=0.0, help="noise per axis of sensed robots [m]")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--robots", type=int, default=100, help="the leader included")
    parser.add_argument("--kill", type=float, default=0.0, help="share of the placed followers that die")
    parser.add_argument("--growth", type=float, nargs="+", help="instead: plan places in balls of these radii [m]")
    parser.add_argument("--missions", type=float, nargs="+", default=(), help="with --growth: whole missions in these")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Run what the command line asks for, and print the table; return the exit code."""
    arguments = parsed(words)
    if arguments.growth:
        print(GROWTH_HEADER)
        for line in growth(arguments.growth, arguments.missions):
            print(line, flush=True)
        return 0
    print(HEADER)
    for name in arguments.experiment:
        done = list(trials(arguments, name))
        print(row(name, arguments, done), flush=True)
        if arguments.kill:
            print(repair(done), flush=True)
        if arguments.offset_sigma:
            print(depths(done, arguments.offset_sigma), flush=True)
    return 0
