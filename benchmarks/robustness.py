"""Measures how the decision bears a bad radio, dying robots and a network that falls apart; prints Markdown tables.

Three experiments, each over seeds: `loss` (frames lost and delayed), `kills` (a fifth of the robots, three of the eight
that carry a position sensor among them, dies at random ticks) and `split` (an obstacle field parts the network, which
merges again behind it). Every run has a process of its own. With ``--out FILE`` each finished run is appended to the
file as a line of JSON, and runs that the file has are not run again; Ctrl-C keeps and prints what was done.

Exit code 0: all runs were achieved without a collision and all targets are met; 1: the last lines say which are not;
2: bad input; 130: interrupted.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeGuard

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from result_file import open_results
from robustness_report import VARIANTS, Report
from robustness_watch import WATCHED, SplitWatch

from bringup.arguments import EngineKind
from bringup.compose import ScenarioActors
from bringup.engine import Engine
from bringup.inprocess import InProcessEngine
from bringup.layout import sensor_carriers
from bringup.resolution import resolve
from bringup.results import Outcome, Timing, formation_metrics
from bringup.scenario_file import Override, load_scenario, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from studies.campaign import Record, ResultFile
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.randomness import rng_for
from swarm_sim.config import Backend
from swarm_sim.metrics.trace import TraceRecorder

EXPERIMENTS = tuple(sorted({variant.experiment for variant in VARIANTS}))
SHAPES = ("formation_1", "formation_2", "formation_3", "formation_4")
KILLED_SHARE, KILLED_BEACONS = 0.2, 3
KILLED_FROM_S, KILLED_TO_S = 10.0, 110.0  # the last ones when most robots are parked
KEPT = (
    *("achieved", "reason", "settling_time_s", "bottleneck_time_s", "displacement_ratio", "collisions"),
    *("min_clearance_m", "lost_robots", "radio_neighborhood_peak_bps", "localization_rmse_m", "wall_time_s"),
)


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
    """Run what is missing, print tables and missed targets, and return the exit code."""
    try:
        options = _parser().parse_args(arguments)
        tasks = list(_tasks(options))
        file = open_results(options.out)
        try:
            _run_missing(tasks, file, 1 if options.engine == EngineKind.ROS.value else options.processes)
        except KeyboardInterrupt:
            print("interrupted; the table has what was done", file=sys.stderr)
            _print(tasks, file)
            return 130
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    is_met = _print(tasks, file)
    if options.figure is not None:
        _report(tasks, file).draw(options.figure)
    return 0 if is_met else 1


def _run_missing(tasks: Sequence[Task], file: ResultFile, processes: int) -> None:
    missing = [task for task in tasks if not is_whole(file.records.get(task.key))]
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
    ) as progress:
        bar = progress.add_task("runs", total=len(tasks), completed=len(tasks) - len(missing))
        for task, result in _completed(missing, processes):
            file.append(task.key, result)
            progress.update(bar, advance=1, description=f"{task.variant}, seed {task.seed}")


def _print(tasks: Sequence[Task], file: ResultFile) -> bool:
    """Print tables, missed targets and what to know of the numbers; return whether no target was missed."""
    is_met = _report(tasks, file).print()
    if warning := file.warning(task.key for task in tasks):
        print(f"\n**{warning}**")
    return is_met


def _report(tasks: Sequence[Task], file: ResultFile) -> Report:
    done = [file.records.get(task.key) for task in tasks]
    return Report([record for record in done if is_whole(record)])


def is_whole(record: Record | None) -> TypeGuard[Record]:
    """Return whether a result has all numbers; one of an older benchmark may lack some, and is made anew."""
    return record is not None and record.keys() >= {*Task.__dataclass_fields__, *KEPT, *WATCHED}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "experiments",
        nargs="*",
        metavar="EXPERIMENT",
        type=_experiment,
        help=f"{', '.join(EXPERIMENTS)} (default: all)",
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(1, 11)), help="default: 1 to 10")
    parser.add_argument("--engine", choices=[kind.value for kind in EngineKind], default="inprocess")
    parser.add_argument("--physics", choices=[kind.value for kind in Backend], default="massdamper")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings", help="any setting")
    parser.add_argument("--out", type=Path, help="file of results, one line of JSON per run; what it has is not rerun")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="at a time; ROS runs go one by one")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="where to draw the results, a PNG")
    return parser


def _experiment(text: str) -> str:
    if text not in EXPERIMENTS:
        raise argparse.ArgumentTypeError(f"there is no experiment '{text}'; choose from {', '.join(EXPERIMENTS)}")
    return text


def _tasks(options: argparse.Namespace) -> Iterator[Task]:
    for variant in VARIANTS:
        if options.experiments and variant.experiment not in options.experiments:
            continue
        for seed in options.seeds:
            settings = (*variant.settings, *options.settings)
            yield Task(
                variant.name, seed, options.engine, options.physics, settings, variant.experiment, variant.scenario
            )


def _completed(tasks: Sequence[Task], processes: int) -> Iterator[tuple[Task, Record]]:
    """Yield the results of tasks as they come; a stop leaves no process behind."""
    context = multiprocessing.get_context("spawn")  # a fresh process each: ROS can be used only once in one
    pool = ProcessPoolExecutor(processes, mp_context=context, max_tasks_per_child=1)
    running: dict[Future[Record], Task] = {}
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


def run(task: Task) -> Record:
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
            recorder.record(record.truth, record.reports, record.camera)
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


if __name__ == "__main__":
    sys.exit(main())
