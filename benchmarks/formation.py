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
from statistics import fmean
from typing import Any

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

QUALITY_COLUMNS: dict[str, Callable[[Metrics], str]] = {
    "seed": lambda m: str(m["seed"]),
    "shape": lambda m: m["shape"].removeprefix("formation_"),
    "achieved": lambda m: "yes" if m["achieved"] else f"no: {m['reason']}",
    "collisions": lambda m: str(m["collisions"]),
    "displacement [m]": lambda m: _number(m["total_displacement_m"]),
    "/ bound": lambda m: _number(m["displacement_ratio"], 3),
    "settling [s]": lambda m: _number(m["settling_time_s"]),
    "/ bottleneck": lambda m: _number(_slowness(m), 3),
    "localization rms / p99 / max [m]": lambda m: " / ".join(
        _number(m[f"localization_{name}_m"], 2) for name in ("rmse", "p99", "max")
    ),
    "NEES in band": lambda m: _number(m["localization_consistent"], 3),
    "peak around a radio [kbit/s]": lambda m: _number(m["radio_neighborhood_peak_bps"] / 1000.0),
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
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(1, 21)), help="of the quality table")
    parser.add_argument("--table", choices=["quality", "speed", "both"], default="both")
    return parser


def _quality(scenario: str, seeds: Sequence[int]) -> bool:
    """Print one row per seed, on the ROS engine, the shapes in turn; return whether all runs were achieved."""
    print(f"\n### Quality: {scenario}, ROS engine, PyBullet\n")
    _print_row(list(QUALITY_COLUMNS))
    _print_row(["---"] * len(QUALITY_COLUMNS))
    rows = []
    for seed in seeds:
        shape = SHAPES[(seed - 1) % len(SHAPES)]
        metrics = _run(scenario, seed, (*SPEED_CASES[0].options, "--shape", shape)) | {"shape": shape}
        _print_row([column(metrics) for column in QUALITY_COLUMNS.values()])
        rows.append(metrics)
    achieved = sum(metrics["achieved"] for metrics in rows)
    collisions = sum(metrics["collisions"] for metrics in rows)
    print(f"\n{achieved} of {len(rows)} achieved, {collisions} collisions; means and worst:")
    for name, values in {
        "displacement / bound": [metrics["displacement_ratio"] for metrics in rows],
        "settling / bottleneck": [_slowness(metrics) for metrics in rows],
        "localization rms [m]": [metrics["localization_rmse_m"] for metrics in rows],
        "peak around a radio [kbit/s]": [metrics["radio_neighborhood_peak_bps"] / 1000.0 for metrics in rows],
    }.items():
        known = [value for value in values if value is not None]
        if known:
            print(f"- {name}: {fmean(known):.3f}, {max(known):.3f}")
    return achieved == len(rows)


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


def _slowness(metrics: Metrics) -> float | None:
    """Return the settling time over what the longest of the shortest paths takes at full speed."""
    settling, bottleneck = metrics["settling_time_s"], metrics["bottleneck_time_s"]
    return None if settling is None or bottleneck is None else settling / bottleneck


def _number(value: float | None, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _print_row(cells: Sequence[str]) -> None:
    print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
