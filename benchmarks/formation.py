"""Measures the formation system: runs `formation-50` as a user would, and prints Markdown tables from metrics.json.

One run at a time, each a process of its own, so that no measurement profits from what another has loaded.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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

QUALITY_COLUMNS: dict[str, Callable[[Metrics], str]] = {
    "seed": lambda m: str(m["seed"]),
    "achieved": lambda m: "yes" if m["achieved"] else f"no: {m['reason']}",
    "collisions": lambda m: str(m["collisions"]),
    "displacement [m]": lambda m: _number(m["total_displacement_m"]),
    "/ bound": lambda m: _number(m["displacement_ratio"], 3),
    "settling [s]": lambda m: _number(m["settling_time_s"]),
    "bottleneck [s]": lambda m: _number(m["bottleneck_time_s"]),
    "1.25 x bottleneck + 10 [s]": lambda m: _number(_settling_limit(m)),
    "radio peak [kbit/s]": lambda m: _number(m["radio_peak_bps"] / 1000.0),
}

SPEED_COLUMNS: dict[str, Callable[[Metrics], str]] = {
    "start-up [s]": lambda m: _number(m["startup_s"]),
    "simulated [s]": lambda m: _number(m["sim_time_s"]),
    "wall [s]": lambda m: _number(m["wall_time_s"]),
    "x real time": lambda m: _number(m["real_time_factor"]),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and return the exit code: 1 when a run did not reach its mission."""
    options = _parser().parse_args(arguments)
    complete = True
    if options.table in {"quality", "both"}:
        complete &= _quality(options.scenario, options.seeds)
    if options.table in {"speed", "both"}:
        complete &= _speed(options.scenario, options.seeds[0])
    return 0 if complete else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="formation-50", help="what to run (default: %(default)s)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5], help="seeds of the quality table")
    parser.add_argument("--table", choices=["quality", "speed", "both"], default="both")
    return parser


def _quality(scenario: str, seeds: Sequence[int]) -> bool:
    """Print one row per seed, on the ROS engine; return whether all runs were achieved."""
    print(f"\n### Quality: {scenario}, ROS engine, PyBullet\n")
    _print_row(list(QUALITY_COLUMNS))
    _print_row(["---"] * len(QUALITY_COLUMNS))
    achieved = True
    for seed in seeds:
        metrics = _run(scenario, seed, SPEED_CASES[0].options)
        _print_row([column(metrics) for column in QUALITY_COLUMNS.values()])
        achieved &= metrics["achieved"]
    return achieved


def _speed(scenario: str, seed: int) -> bool:
    """Print one row per engine and physics back end; return whether all runs were achieved."""
    print(f"\n### Speed: {scenario}, seed {seed}\n")
    _print_row(["run", *SPEED_COLUMNS])
    _print_row(["---"] * (1 + len(SPEED_COLUMNS)))
    achieved = True
    for case in SPEED_CASES:
        metrics = _run(scenario, seed, case.options)
        _print_row([case.name, *(column(metrics) for column in SPEED_COLUMNS.values())])
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


def _settling_limit(metrics: Metrics) -> float | None:
    """Return the time that a good run may take to settle [s]: the longest way at full speed, and some more."""
    bottleneck = metrics["bottleneck_time_s"]
    return None if bottleneck is None else 1.25 * bottleneck + 10.0


def _number(value: float | None, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _print_row(cells: Sequence[str]) -> None:
    print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
