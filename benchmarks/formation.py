"""Measures the formation system: runs `formation-50` as a user would, and prints Markdown tables from metrics.json.

One run at a time, each a process of its own, so that no measurement profits from what another has loaded. With
``--out FILE`` finished runs of the quality table are kept, and are not run again; ``--figure FILE`` draws that table.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from statistics import fmean
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from drawing import draw_groups, explain, panels, save
from result_file import open_results
from tables import number, print_head, print_row

from bringup.results import FormationMetrics
from studies.campaign import ResultFile
from swarm_msgs_py.errors import ConfigError

SHAPES = ("formation_1", "formation_2", "formation_3", "formation_4")
LAUNCHER = Path(__file__).resolve().parents[1] / "scripts" / "launch_swarm.py"
Metrics = dict[str, Any]


@dataclass(frozen=True)
class Case:
    """One way to run the scenario, and the words for it in the table."""

    name: str
    options: tuple[str, ...]


SPEED_CASES = (
    Case("ROS, PyBullet, agents grouped", ("--engine", "ros", "--physics", "bullet")),
    Case(
        "ROS, PyBullet, one process per robot", ("--engine", "ros", "--physics", "bullet", "--agents-per-process", "1")
    ),
    Case("in-process, PyBullet", ("--engine", "inprocess", "--physics", "bullet")),
    Case("in-process, mass-damper", ("--engine", "inprocess", "--physics", "massdamper")),
)


def _slowness(metrics: Metrics) -> float | None:
    """Return the settling time over what the longest of the shortest paths takes at full speed."""
    settling, bottleneck = metrics["settling_time_s"], metrics["bottleneck_time_s"]
    return None if settling is None or bottleneck is None else settling / bottleneck


QUALITY_COLUMNS: dict[str, Callable[[Metrics], str]] = {
    "seed": lambda m: str(m["seed"]),
    "shape": lambda m: m["shape"].removeprefix("formation_"),
    "achieved": lambda m: "yes" if m["achieved"] else f"no: {m['reason']}",
    "collisions": lambda m: str(m["collisions"]),
    "displacement [m]": lambda m: number(m["total_displacement_m"]),
    "/ bound": lambda m: number(m["displacement_ratio"], 3),
    "settling [s]": lambda m: number(m["settling_time_s"]),
    "/ bottleneck": lambda m: number(_slowness(m), 3),
    "localization rms / p99 / max [m]": lambda m: " / ".join(
        number(m[f"localization_{name}_m"], 2) for name in ("rmse", "p99", "max")
    ),
    "NEES in band": lambda m: number(m["localization_consistent"], 3),
    "peak around a radio [kbit/s]": lambda m: number(m["radio_neighborhood_peak_bps"] / 1000.0),
}

METRICS = frozenset({"shape", *(field.name for field in fields(FormationMetrics))})
QUALITY_FIGURES: dict[str, tuple[Callable[[Metrics], float | None], float]] = {
    "displacement / bound": (lambda m: m["displacement_ratio"], 1.15),
    "settling / bottleneck": (_slowness, 1.35),
    "localization rms [m]": (lambda m: m["localization_rmse_m"], 0.33),
    "peak around a radio [kbit/s]": (lambda m: m["radio_neighborhood_peak_bps"] / 1000.0, 250.0),
}
"""What the table sums up, with the value that is aimed at."""

SPEED_COLUMNS: dict[str, Callable[[Metrics], str]] = {
    "start-up [s]": lambda m: number(m["startup_s"]),
    "simulated [s]": lambda m: number(m["sim_time_s"]),
    "wall [s]": lambda m: number(m["wall_time_s"]),
    "x real time": lambda m: number(m["real_time_factor"]),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return the exit code: 1 when a run did not reach its mission."""
    options = _parser().parse_args(arguments)
    try:
        file = open_results(options.out)
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    complete = True
    if options.table in {"quality", "both"}:
        rows = [
            metrics
            for method in options.methods or [None]
            for metrics in _quality(options.scenario, method, options.seeds, file)
        ]
        complete &= all(metrics["achieved"] and not metrics["collisions"] for metrics in rows)
        if options.figure is not None:
            _draw(rows, options.figure)
    if options.table in {"speed", "both"}:
        complete &= _speed(options.scenario, options.seeds[0])
    return 0 if complete else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="formation-50", help="what to run (default: %(default)s)")
    parser.add_argument("--methods", nargs="+", metavar="M", help="of the quality table (default: the scenario's)")
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(1, 21)), help="of the quality table")
    parser.add_argument("--out", type=Path, help="file of runs of the quality table, one line of JSON each")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="where to draw the quality table, a PNG")
    parser.add_argument("--table", choices=["quality", "speed", "both"], default="both")
    return parser


def _quality(scenario: str, method: str | None, seeds: Sequence[int], file: ResultFile) -> list[Metrics]:
    """Print one row per seed, on the ROS engine, the shapes in turn; return what the rows are of."""
    name = scenario if method is None else f"{scenario}, {method}"
    print(f"\n### Quality: {name}, ROS engine, PyBullet\n")
    print_head(list(QUALITY_COLUMNS))
    rows: list[Metrics] = []
    keys: list[str] = []
    for seed in seeds:
        shape = SHAPES[(seed - 1) % len(SHAPES)]
        key = f"{name}, {shape}, seed {seed}"
        if not file.records.get(key, {}).keys() >= METRICS:  # missing, or of a launcher that measured less
            chosen = () if method is None else ("--method", method)
            options = (*SPEED_CASES[0].options, "--shape", shape, *chosen)
            file.append(key, _run(scenario, seed, options) | {"shape": shape})
        metrics = dict(file.records[key])
        print_row([column(metrics) for column in QUALITY_COLUMNS.values()])
        rows.append(metrics)
        keys.append(key)
    if warning := file.warning(keys):
        print(f"\n**{warning}**")
    achieved = sum(metrics["achieved"] for metrics in rows)
    collisions = sum(metrics["collisions"] for metrics in rows)
    print(f"\n{achieved} of {len(rows)} achieved, {collisions} collisions; means and worst:")
    for name, (value, _) in QUALITY_FIGURES.items():
        known = _known(rows, value)
        if known:
            print(f"- {name}: {fmean(known):.3f}, {max(known):.3f}")
    return rows


def _known(rows: Sequence[Metrics], value: Callable[[Metrics], float | None]) -> list[float]:
    return [number for number in map(value, rows) if number is not None]


def _draw(rows: Sequence[Metrics], file: Path) -> None:
    """Draw a panel per quantity, with a column per shape."""
    figure, axes = panels(len(QUALITY_FIGURES), 3.4)
    for one, (title, (value, target)) in zip(axes, QUALITY_FIGURES.items(), strict=True):
        groups = {
            f"shape {shape[-1]}": _known([metrics for metrics in rows if metrics["shape"] == shape], value)
            for shape in SHAPES
        }
        draw_groups(one, title, groups, dict.fromkeys(groups, target))
    explain(figure, axes[0])
    save(figure, file)


def _speed(scenario: str, seed: int) -> bool:
    """Print one row per engine and physics back end; return whether all runs were achieved."""
    print(f"\n### Speed: {scenario}, seed {seed}\n")
    print_head(["run", *SPEED_COLUMNS])
    achieved = True
    for case in SPEED_CASES:
        metrics = _run(scenario, seed, case.options)
        print_row([case.name, *(column(metrics) for column in SPEED_COLUMNS.values())])
        achieved &= metrics["achieved"]
    return achieved


def _run(scenario: str, seed: int, options: Sequence[str]) -> Metrics:
    """Run the launcher once and return its metrics; a run that cannot start ends the benchmark with its message."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        command = [sys.executable, str(LAUNCHER), "--scenario", scenario, "--seed", str(seed), "--out", str(folder)]
        run = subprocess.run(
            [*command, *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        report = folder / "metrics.json"
        if not report.exists():
            sys.exit(f"{' '.join([*command, *options])} ended with {run.returncode}:\n{run.stdout}")
        metrics: Metrics = json.loads(report.read_text(encoding="utf-8"))
        return metrics


if __name__ == "__main__":
    sys.exit(main())
