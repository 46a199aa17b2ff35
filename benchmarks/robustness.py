"""Measures how the decision bears a bad radio, dying robots and a network that falls apart; prints Markdown tables.

Three experiments, each over seeds: `loss` (frames lost and delayed), `kills` (a fifth of the robots, three of the eight
that carry a position sensor among them, dies at random ticks) and `split` (an obstacle field parts the network, which
merges again behind it). Every run has a process of its own. With ``--out FILE`` each finished run is appended to the
file as a line of JSON, and runs that the file has are not run again; Ctrl-C keeps and prints what was done.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from drawing import draw_groups, explain, panels, save
from robustness_watch import SplitWatch
from run_log import Result, RunLog
from tables import number, print_head, print_row

from bringup.arguments import EngineKind
from bringup.compose import ScenarioActors
from bringup.engine import Engine
from bringup.inprocess import InProcessEngine
from bringup.labels import first_few
from bringup.layout import sensor_carriers
from bringup.resolution import resolve
from bringup.results import Outcome, Timing, formation_metrics
from bringup.scenario_file import Override, load_scenario, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import NodeId, robot_name
from swarm_sim.config import Backend
from swarm_sim.metrics.trace import TraceRecorder

SHAPES = ("formation_1", "formation_2", "formation_3", "formation_4")
KILLED_SHARE, KILLED_BEACONS = 0.2, 3
KILLED_FROM_S, KILLED_TO_S = 10.0, 110.0  # the last ones when most robots are parked
KEPT = (
    *("achieved", "reason", "settling_time_s", "bottleneck_time_s", "displacement_ratio", "collisions"),
    *("min_clearance_m", "lost_robots", "radio_neighborhood_peak_bps", "wall_time_s"),
)


@dataclass(frozen=True)
class Variant:
    """One way to make it hard, and the settings for it."""

    experiment: str
    name: str
    scenario: str
    settings: tuple[str, ...] = ()
    ratio_max: float | None = None  # of the settling time to that of the same seeds in `BASE`


BASE = "no loss, no delay"
AGREED_MAX_S = 10.0  # from the merge of two networks to one agreed assignment
VARIANTS = (
    Variant("loss", BASE, "formation-50"),
    Variant("loss", "loss 0 %, delay", "formation-50", ("delay_ticks_max=1",), 1.0),
    Variant("loss", "loss 10 %, delay", "formation-50", ("radio.loss=0.1", "delay_ticks_max=1"), 1.1),
    Variant("loss", "loss 30 %, delay", "formation-50", ("radio.loss=0.3", "delay_ticks_max=1"), 1.3),
    Variant("kills", "20 % killed", "formation-50"),
    Variant("split", "split and merge", "split-24"),
)
COLUMNS: dict[str, Callable[[Sequence[Result]], str]] = {
    "runs": lambda runs: str(len(runs)),
    "achieved": lambda runs: str(sum(run["achieved"] for run in runs)),
    "collisions": lambda runs: str(sum(run["collisions"] for run in runs)),
    "least gap [m]": lambda runs: number(min(run["min_clearance_m"] for run in runs), 3),
    "settling, mean / worst [s]": lambda runs: _mean_and_worst(runs, "settling_time_s"),
    "displacement / bound": lambda runs: _mean_and_worst(runs, "displacement_ratio", 3),
    "neighborhood peak [kbit/s]": lambda runs: number(max(run["radio_neighborhood_peak_bps"] for run in runs) / 1000.0),
}
SPLIT_COLUMNS: dict[str, Callable[[Sequence[Result]], str]] = {
    "longest split, mean / worst [s]": lambda runs: _mean_and_worst(runs, "longest_split_s"),
    "busy apart, with / without computer": lambda runs: (
        f"{_worst_low(runs, 'busy_with_computer')} / {_worst_low(runs, 'busy_without_computer')}"
    ),
    "agreed after the merge, mean / worst [s]": lambda runs: _mean_and_worst(runs, "agreed_after_s"),
}


@dataclass(frozen=True)
class Task:
    """One run; the fields but the last two say which, in the file of results."""

    variant: str
    seed: int
    engine: str
    physics: str
    settings: tuple[str, ...]
    experiment: str
    scenario: str

    @property
    def key(self) -> str:
        """What tells this run from others."""
        return json.dumps([self.variant, self.seed, self.engine, self.physics, list(self.settings)])


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is missing, print tables, and return the exit code: 1 when a run failed, 130 after Ctrl-C."""
    options = _parser().parse_args(arguments)
    tasks = list(_tasks(options))
    log = RunLog(options.out, _key_of)
    missing = [task for task in tasks if task.key not in log.results]
    try:
        with Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=Console(stderr=True),
        ) as progress:
            bar = progress.add_task("runs", total=len(tasks), completed=len(tasks) - len(missing))
            for task, result in _completed(missing, 1 if options.engine == "ros" else options.processes):
                log.add(result)
                progress.update(bar, advance=1, description=f"{task.variant}, seed {task.seed}")
    except KeyboardInterrupt:
        print("interrupted; the table has what was done", file=sys.stderr)
        _print_tables(tasks, log.results)
        return 130
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    succeeded = _print_tables(tasks, log.results)
    if options.figure is not None:
        _draw([log.results[task.key] for task in tasks], options.figure)
    return 0 if succeeded else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    experiments = sorted({variant.experiment for variant in VARIANTS})
    parser.add_argument("experiments", nargs="*", metavar="EXPERIMENT", help=f"{', '.join(experiments)} (default: all)")
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(1, 11)), help="default: 1 to 10")
    parser.add_argument("--engine", choices=[kind.value for kind in EngineKind], default="inprocess")
    parser.add_argument("--physics", choices=[kind.value for kind in Backend], default="massdamper")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings", help="any setting")
    parser.add_argument("--out", type=Path, help="file of results, one line of JSON per run; what it has is not rerun")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="at a time; ROS runs go one by one")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="where to draw the results, a PNG")
    return parser


def _tasks(options: argparse.Namespace) -> Iterator[Task]:
    known = {variant.experiment for variant in VARIANTS}
    if unknown := sorted(set(options.experiments) - known):
        sys.exit(f"error: there is no experiment '{unknown[0]}'; choose from {', '.join(sorted(known))}")
    for variant in VARIANTS:
        if options.experiments and variant.experiment not in options.experiments:
            continue
        for seed in options.seeds:
            settings = (*variant.settings, *options.settings)
            yield Task(
                variant.name, seed, options.engine, options.physics, settings, variant.experiment, variant.scenario
            )


def _key_of(result: Result) -> str:
    return Task(**{name: result[name] for name in Task.__dataclass_fields__}).key


def _completed(tasks: Sequence[Task], processes: int) -> Iterator[tuple[Task, Result]]:
    """Yield the results of tasks as they come; a stop leaves no process behind."""
    context = multiprocessing.get_context("spawn")  # a fresh process each: ROS can be used only once in one
    pool = ProcessPoolExecutor(processes, mp_context=context, max_tasks_per_child=1)
    running: dict[Future[Result], Task] = {}
    waiting = list(reversed(tasks))
    try:
        while waiting or running:
            while waiting and len(running) < processes:
                task = waiting.pop()
                running[pool.submit(run, task)] = task
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                yield running.pop(future), future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def run(task: Task) -> Result:
    """Run one task in this process and return what was measured."""
    scenario, origin = load_scenario(task.scenario, _overrides(task))
    scenario = resolve(scenario, origin)
    actors = ScenarioActors(scenario)
    recorder = TraceRecorder(actors.robots, scenario.sim.period_s)
    supervisor = Supervisor(actors.robots, scenario.success, scenario.sim.period_s, scenario.duration_s)
    watch = SplitWatch(scenario, actors.scene)
    verdict, began = Verdict(False, "the engine ended by itself"), time.monotonic()
    engine = _engine(task, actors)
    with engine:
        for record in engine.ticks():
            recorder.record(record.truth, record.reports)
            watch.take(record)
            ended = supervisor.watch(record)
            if ended is not None:
                verdict = ended
                break
    outcome = Outcome(recorder, supervisor, verdict, Timing(engine.startup_s, time.monotonic() - began))
    metrics = asdict(formation_metrics(scenario, task.engine, outcome))
    return {**asdict(task), **{name: metrics[name] for name in KEPT}, **watch.summary()}


def _overrides(task: Task) -> tuple[Override, ...]:
    settings = [f"seed={task.seed}", f"sim.physics.backend={task.physics}"]
    if task.scenario == "formation-50":
        settings.append(f"shape.name={SHAPES[(task.seed - 1) % len(SHAPES)]}")
    overrides = [parse_assignment(text) for text in (*settings, *task.settings)]
    if task.experiment == "kills":
        scenario, _ = load_scenario(task.scenario, tuple(overrides))
        beacons = sensor_carriers(scenario)
        events = kills(task.seed, scenario.robots.count, beacons, scenario.sim.period_s)
        overrides.append(Override("kills", "events", events))
    return tuple(overrides)


def kills(seed: int, robots: int, beacons: Collection[int], period_s: float) -> list[dict[str, Any]]:
    """Return the events that kill a fifth of the robots, `KILLED_BEACONS` beacons among them.

    Who and when is drawn from the seed. If there are too few other robots, more beacons die.
    """
    rng = rng_for(seed, "robustness-kills", 0)
    count = round(KILLED_SHARE * robots)
    some = rng.permutation(sorted(beacons))[:KILLED_BEACONS].tolist()
    others = rng.permutation(sorted(set(range(robots)) - set(beacons))).tolist()
    spare = [robot for robot in sorted(beacons) if robot not in some]
    victims = [*some, *others, *spare][:count]
    ticks = rng.integers(round(KILLED_FROM_S / period_s), round(KILLED_TO_S / period_s), size=len(victims))
    pairs = sorted(zip(ticks.tolist(), victims, strict=True))
    return [{"at_s": tick * period_s, "kill": [victim]} for tick, victim in pairs]


def _engine(task: Task, actors: ScenarioActors) -> Engine:
    if task.engine == EngineKind.INPROCESS.value:
        return InProcessEngine(actors)
    from bringup.ros_engine import RosEngine  # noqa: PLC0415 - everything else works where ROS is not installed

    return RosEngine(actors)


def _print_tables(tasks: Sequence[Task], done: dict[str, Result]) -> bool:
    """Print a table per experiment; return whether all runs are there and were achieved without a collision."""
    results = [done[task.key] for task in tasks if task.key in done]
    for experiment in dict.fromkeys(task.experiment for task in tasks):
        own = [result for result in results if result["experiment"] == experiment]
        if own:
            _print_table(experiment, own)
    failed = [run for run in results if not run["achieved"] or run["collisions"]]
    for one in failed:
        print(f"* {one['variant']}, seed {one['seed']}: {one['reason']}; {one['collisions']} collisions")
    return not failed and len(results) == len(tasks)


def _print_table(experiment: str, results: Sequence[Result]) -> None:
    columns = {**COLUMNS, **(SPLIT_COLUMNS if experiment == "split" else {})}
    ratios = ["x without loss", "target"] if experiment == "loss" else []
    print(f"\n### {experiment}: {results[0]['scenario']}, {results[0]['engine']}, {results[0]['physics']}\n")
    print_head(["variant", *columns, *ratios])
    variants = [variant for variant in VARIANTS if variant.experiment == experiment]
    base = {run["seed"]: run["settling_time_s"] for run in results if run["variant"] == BASE}
    for variant in variants:
        runs = [run for run in results if run["variant"] == variant.name]
        if not runs:
            continue
        cells = [variant.name, *(column(runs) for column in columns.values())]
        if ratios:
            cells += [_ratio(runs, base), number(variant.ratio_max)]
        print_row(cells)


def _draw(results: Sequence[Result], file: Path) -> None:
    """Draw a panel for each experiment that there are results of."""
    by_variant = {name: [run for run in results if run["variant"] == name] for name in (v.name for v in VARIANTS)}
    base = {run["seed"]: run["settling_time_s"] for run in by_variant[BASE]}
    slowness = {
        v.name: [
            run["settling_time_s"] / base[run["seed"]]
            for run in by_variant[v.name]
            if run["settling_time_s"] is not None and base.get(run["seed"]) is not None
        ]
        for v in VARIANTS
        if v.experiment == "loss" and v.name != BASE
    }
    kills = {
        name: [run["settling_time_s"] for run in by_variant[name] if run["settling_time_s"] is not None]
        for name in (BASE, "20 % killed")
    }
    agreed = [run["agreed_after_s"] for run in by_variant["split and merge"] if run["agreed_after_s"] is not None]
    targets = {v.name: v.ratio_max for v in VARIANTS}
    shown = [
        ("settling / that of the same seed without loss", slowness, targets),
        ("settling [s], robots dying", kills, {}),
        ("from merge to one agreed assignment [s]", {"split and merge": agreed}, {"split and merge": AGREED_MAX_S}),
    ]
    shown = [panel for panel in shown if any(panel[1].values())]
    figure, axes = panels(len(shown))
    for one, (title, groups, limits) in zip(axes, shown, strict=True):
        draw_groups(
            one,
            title,
            {name.replace(", ", "\n"): v for name, v in groups.items()},
            {name.replace(", ", "\n"): limit for name, limit in limits.items()},
        )
    explain(figure, axes[0])
    save(figure, file)


def _ratio(runs: Sequence[Result], base: dict[int, float | None]) -> str:
    """Return by how much longer settling took than in the base runs of the same seeds: of the means, and the worst."""
    pairs = [(run["settling_time_s"], base.get(run["seed"])) for run in runs]
    both = [(own, other) for own, other in pairs if own is not None and other is not None]
    if not both:
        return "-"
    own, other = np.array(both).T
    return f"{own.mean() / other.mean():.3f}, worst {(own / other).max():.3f}"


def _mean_and_worst(runs: Sequence[Result], name: str, digits: int = 1) -> str:
    values = [run[name] for run in runs if run[name] is not None]
    missing = [robot_name(NodeId(run["seed"]))[1:] for run in runs if run[name] is None]
    text = f"{fmean(values):.{digits}f} / {max(values):.{digits}f}" if values else "-"
    return f"{text} (none: seed {first_few(missing)})" if missing else text


def _worst_low(runs: Sequence[Result], name: str) -> str:
    values = [run[name] for run in runs if run[name] is not None]
    return f"{min(values):.2f}" if values else "-"


if __name__ == "__main__":
    sys.exit(main())
