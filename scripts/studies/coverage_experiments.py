"""The coverage paper's experiments E1 to E4, many seeds each, as one table row per method (spec section 11)."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bringup.coverage.starts import LEADER
from bringup.option_types import OneLineParser, complain, number, whole
from studies.campaign import ResultFile
from studies.campaign_folder import locked, open_results
from studies.coverage_growth import GROWTH_HEADER, growth
from studies.coverage_mission import CoverageMission, Event
from studies.coverage_plans import PLAN_HEADER, plan_row
from swarm_agent.coverage.config import CoverageConfig, Expansion, MotionConfig, Rule
from swarm_msgs_py.errors import ConfigError
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
DRIFTING, DRIFTING_SPARE = 0.76, 0.1  # placement where robots drift, and share of the range that layouts hold back
TICKS_MAX = 3000
DEATHS_UNTIL = 130
"""With `--deaths`, robots die in ticks before this: while they gather, wait, travel, and hold their places."""
HEADER = (
    "experiment  rule    expansion  seeds done robots       rendezvous  expansion      lost links  covered"
    "  wall              CPU"
)


@dataclass(frozen=True, slots=True)
class Trial:
    """One mission's outcome and measures; all of it can be written as JSON.

    Attributes
    ----------
    is_complete : bool
    placed : int
        Followers that hold a place at the end.
    rendezvous_s, expansion_s : float
        Simulated [s].
    violations : int
        Ticks with a link missing.
    covered : float
        Share of the volume.
    wall_s, cpu_s : float
        [s].
    components : int
        Pieces at the end.
    spares : int
        Robots that hold a place at the end and did not before others died.
    killed : int
    chains : list of int
        Steps of localization of those who hold places.
    localization : list of float
        Their errors [m].
    """

    is_complete: bool
    placed: int
    rendezvous_s: float
    expansion_s: float
    violations: int
    covered: float
    wall_s: float
    cpu_s: float
    components: int
    spares: int
    killed: int
    chains: list[int]
    localization: list[float]


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


def _placed(agents: CoverageConfig, arguments: argparse.Namespace) -> CoverageConfig:
    """Return the settings with the longest link that the command line asks for."""
    return agents if arguments.placement is None else replace(agents, placement=arguments.placement)


def _steady(agents: CoverageConfig, arguments: argparse.Namespace) -> CoverageConfig:
    """Return the settings for robots that drift: shorter links, and layouts that leave more to spare."""
    placement = DRIFTING if arguments.placement is None else arguments.placement
    motion, layout = replace(agents.motion, drifts=True), replace(agents.layout, spare=DRIFTING_SPARE)
    return replace(agents, placement=placement, motion=motion, layout=layout)


def trials(arguments: argparse.Namespace, name: str, results: ResultFile) -> Iterator[Trial]:
    """Yield one trial per seed, those that are in the file of results from there."""
    solid = solid_from(EXPERIMENTS[name][0])
    probe = CoverageProbe(solid, EXPERIMENTS[name][1], seed=0)
    for seed in range(arguments.seeds):
        key = _key(arguments, name, seed)
        if key not in results.records:
            results.append(key, asdict(_trial(arguments, name, probe, seed)))
        yield Trial(**dict[str, Any](results.records[key]))


def _key(arguments: argparse.Namespace, name: str, seed: int) -> str:
    """Return what tells one trial from all others."""
    numbers = [f"{what}={getattr(arguments, what):g}" for what in ("sigma", "offset_sigma", "kill", "robots")]
    drifts = ["drifts"] if arguments.drifts else []
    placed = [] if arguments.placement is None else [f"placement={arguments.placement:g}"]
    deaths = [f"deaths={arguments.deaths:g}"] if arguments.deaths else []
    return " ".join([name, arguments.rule, arguments.expansion, *numbers, *drifts, *placed, *deaths, f"seed={seed}"])


def _trial(arguments: argparse.Namespace, name: str, probe: CoverageProbe, seed: int) -> Trial:
    """Run one mission; with `--kill`, that share of the placed followers dies once the shape is covered.

    With `--deaths`, that share of all followers dies on the way there, each in a tick of its own.
    """
    shape, radius = EXPERIMENTS[name]
    rule, expansion = Rule(arguments.rule), Expansion(arguments.expansion)
    agents, world = settings_of(name, rule, expansion, arguments.sigma, arguments.offset_sigma)
    agents = _placed(agents, arguments)
    if arguments.drifts:
        agents = _steady(agents, arguments)
    wall, cpu = time.perf_counter(), time.process_time()
    mission = CoverageMission(shape, agents, replace(world, drifts=arguments.drifts), arguments.robots, seed)
    outcome = mission.run(TICKS_MAX, _deaths(arguments, seed))
    before, count = set(mission.watch.holders), 0
    if arguments.kill:
        placed = sorted(before - {LEADER})
        count = round(arguments.kill * len(placed))
        mission.kill(rng_for(seed, "coverage", "kill").choice(placed, count, replace=False).tolist())
        outcome = mission.run(2 * TICKS_MAX)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    errors = mission.watch.errors(radius, np.zeros(3))
    return Trial(
        outcome.is_complete,
        outcome.placed,
        outcome.rendezvous_s,
        outcome.expansion_s,
        outcome.violations,
        probe.measure(outcome.positions).covered_fraction,
        wall,
        cpu,
        mission.watch.components,
        len(set(mission.watch.holders) - before),
        count,
        errors.chains.tolist(),
        errors.localization.tolist(),
    )


def _deaths(arguments: argparse.Namespace, seed: int) -> Event:
    """Return the event that ends some followers, each in its tick."""
    rng = rng_for(seed, "coverage", "deaths")
    victims = rng.choice(
        np.arange(1, arguments.robots), round(arguments.deaths * (arguments.robots - 1)), replace=False
    )
    ticks = rng.integers(1, DEATHS_UNTIL, len(victims))

    def strike(mission: CoverageMission) -> None:
        if len(victims) and mission.world.tick < DEATHS_UNTIL:
            mission.watch.expect()  # for there is more to come
        if struck := victims[ticks == mission.world.tick].tolist():
            mission.kill(struck)

    return strike


def row(name: str, arguments: argparse.Namespace, done: Sequence[Trial]) -> str:
    """Return the line of the table for all trials of one experiment."""
    robots = np.array([trial.placed for trial in done])
    expansion = np.array([trial.expansion_s for trial in done])
    return (
        f"{name:11s} {arguments.rule:7s} {arguments.expansion:10s} {len(done):5d}"
        f" {sum(trial.is_complete for trial in done):4d}"
        f" {robots.mean():5.2f} ({robots.min()}-{robots.max()})"
        f"  {max(trial.rendezvous_s for trial in done):5.0f} s max"
        f"  {expansion.mean():4.0f} s, {expansion.max():4.0f} max"
        f"  {sum(trial.violations for trial in done):5d}"
        f"    {np.mean([trial.covered for trial in done]):.5f}"
        f"  {np.mean([trial.wall_s for trial in done]):.1f} s, {max(trial.wall_s for trial in done):.1f} max"
        f"  {np.mean([trial.cpu_s for trial in done]):.1f} s"
    )


def repair(done: Sequence[Trial]) -> str:
    """Return the line on what losses cost."""
    spares = np.array([trial.spares / trial.killed for trial in done if trial.killed])
    least = min(trial.covered for trial in done)
    return (
        f"            {sum(trial.killed for trial in done)} robots killed, {spares.mean():.2f} spare robots for each"
        f" ({spares.max():.2f} max), covered {least:.5f} min, {max(t.components for t in done)} component(s) at most"
    )


def steps(done: Sequence[Trial], sigma: float) -> str:
    """Return the line on errors of localization by steps, against noise of sensing that adds up along the chain."""
    chain = np.concatenate([trial.chains for trial in done])
    error = np.concatenate([trial.localization for trial in done])
    found = [
        f"{h}: {np.sqrt(np.mean(error[chain == h] ** 2)):.3f} ({sigma * np.sqrt(3.0 * h):.3f})"
        for h in np.unique(chain[chain > 0]).tolist()
    ]
    return f"            rms error of localization by steps, theory in brackets [m]  {'  '.join(found)}"


def parsed(words: Sequence[str] | None = None) -> argparse.Namespace:
    """Return what the command line asks for.

    Raises
    ------
    ConfigError
        One line that names the option and the remedy.
    """
    parser = OneLineParser(prog="coverage_study.py", description=__doc__, allow_abbrev=False)
    parser.add_argument("--experiment", nargs="+", choices=sorted(EXPERIMENTS), default=sorted(EXPERIMENTS))
    parser.add_argument("--rule", choices=[rule.value for rule in Rule], default=Rule.LAYOUT.value)
    parser.add_argument("--expansion", choices=[e.value for e in Expansion], default=Expansion.PREDICTED.value)
    parser.add_argument("--sigma", type=number(0.0, 1e3), default=1.0, help="process noise per step and axis [m]")
    parser.add_argument(
        "--offset-sigma", type=number(0.0, 1e3), default=0.0, help="noise per axis of sensed robots [m]"
    )
    parser.add_argument("--seeds", type=whole(1, 10_000), default=20, help="seeds 0 to N - 1")
    parser.add_argument("--robots", type=whole(1, 10_000), default=100, help="the leader included")
    parser.add_argument("--kill", type=number(0.0, 1.0), default=0.0, help="share of the placed followers that die")
    parser.add_argument(
        "--deaths",
        type=number(0.0, 1.0),
        default=0.0,
        help=f"share of the followers that die at any moment of the first {DEATHS_UNTIL} s",
    )
    parser.add_argument("--drifts", action="store_true", help="noise moves robots at rest as well")
    parser.add_argument(
        "--placement",
        type=number(0.1, 1.0),
        help=f"longest planned link, in ranges; {EXACT} without noise, {NOISY} with, {DRIFTING} if robots drift",
    )
    parser.add_argument("--out", type=Path, help="folder that keeps finished missions; the same command goes on there")
    parser.add_argument("--plan", action="store_true", help="instead: plan places by the rule, without messages")
    parser.add_argument(
        "--growth", type=number(1.0, 1e5), nargs="+", help="instead: plan places in balls of these radii [m]"
    )
    parser.add_argument(
        "--missions", type=number(1.0, 1e5), nargs="+", default=(), help="with --growth: whole missions in these"
    )
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Run what the command line asks for, and print the table; return the exit code (0, 2 or 130)."""
    try:
        _run(parsed(words))
    except ConfigError as error:
        complain(error)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


def _run(arguments: argparse.Namespace) -> None:
    if arguments.growth:
        print(GROWTH_HEADER)
        for line in growth(arguments.growth, arguments.missions):
            print(line, flush=True)
    elif arguments.plan:
        _tell_plans(arguments)
    elif arguments.out is None:
        _tell(arguments, ResultFile(None, ""))
    else:
        results = open_results(arguments.out)
        with locked(arguments.out):
            _tell(arguments, results)


def _tell_plans(arguments: argparse.Namespace) -> None:
    """Print a row for each experiment's plans."""
    print(PLAN_HEADER)
    for name in arguments.experiment:
        config, _ = settings_of(name, Rule(arguments.rule), Expansion.SERIAL, arguments.sigma)
        solid = solid_from(EXPERIMENTS[name][0])
        print(plan_row(name, solid, _placed(config, arguments), arguments.seeds), flush=True)


def _tell(arguments: argparse.Namespace, results: ResultFile) -> None:
    """Print a row for each experiment as soon as all of its missions are done."""
    runs = [_key(arguments, name, seed) for name in arguments.experiment for seed in range(arguments.seeds)]
    if warning := results.warning(runs):
        print(warning, file=sys.stderr)
    print(HEADER)
    for name in arguments.experiment:
        done = list(trials(arguments, name, results))
        print(row(name, arguments, done), flush=True)
        if arguments.kill:
            print(repair(done), flush=True)
        if arguments.deaths:
            pieces, least = max(trial.components for trial in done), min(trial.covered for trial in done)
            print(f"            covered {least:.5f} min, {pieces} component(s) at most", flush=True)
        if arguments.offset_sigma:
            print(steps(done, arguments.offset_sigma), flush=True)
