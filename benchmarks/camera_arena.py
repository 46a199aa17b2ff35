"""The arena under its camera, over many seeds: five shapes in a row, against what the thesis' hardware took.

python benchmarks/camera_arena.py [--seeds S ...] [--engine ros|inprocess] [--random-starts] [--set K=V] [--out FILE]

Each run is a process of its own, as a user would start it. The first table has a row per shape: means over the seeds,
with the worst in parentheses. The last has what holds for whole runs. With ``--random-starts`` robots start anywhere,
and form two shapes, of which each seed begins with another; then there are two tables of shapes, of those formed first
and of the others. With ``--out`` finished runs are kept, and are not run again.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from result_file import open_results
from tables import number, print_head, print_row

from studies.campaign import ResultFile
from swarm_msgs_py.errors import ConfigError

LAUNCHER = Path(__file__).resolve().parents[1] / "scripts" / "launch_swarm.py"
RANDOM_STARTS = (
    "robots.start.positions_m=null",
    "robots.start.half_side_m=1.0",
    "robots.start.gap_m=0.06",
)
MM = 1000.0
Metrics = dict[str, Any]


@dataclass(frozen=True)
class Shape:
    """One of the five, and what the thesis' robots took for it (tables 5.2 to 5.6)."""

    name: str
    displacement_m: float
    settling_s: float


SHAPES = (
    Shape("hw_1_trapezoid", 1.75, 23.0),
    Shape("hw_2_square", 1.63, 19.0),
    Shape("hw_3_pentagon", 1.95, 26.0),
    Shape("hw_4_arrow", 2.16, 29.0),
    Shape("hw_5_line", 1.80, 25.0),
)


@dataclass(frozen=True)
class Run:
    """A run that is over.

    Attributes
    ----------
    first : int
        Which of the shapes it began with.
    metrics : dict
    """

    first: int
    metrics: Metrics

    def number(self, name: str, shape: int) -> float | None:
        """Return a number of one of the shapes, None if the run has none."""
        values, at = self.metrics[name] or (), (shape - self.first) % len(SHAPES)
        return values[at] if at < len(values) else None


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; return 1 if a run was not achieved, or robots collided."""
    options = _parser().parse_args(arguments)
    try:
        file = open_results(options.out)
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    runs = [_run(file, options, seed) for seed in options.seeds]
    if options.random_starts:
        for which, before in (("first, from anywhere", 0), ("after another shape", 1)):
            print(f"\nFormed {which}:\n")
            _print_shapes(
                [(k, [run for run in runs if run.first == (k - before) % len(SHAPES)]) for k in range(len(SHAPES))]
            )
    else:
        _print_shapes([(shape, runs) for shape in range(len(SHAPES))])
    rows = [run.metrics for run in runs]
    _print_runs(rows)
    if warning := file.warning([_key(options, seed) for seed in options.seeds]):
        print(f"\n**{warning}**")
    return 0 if all(metrics["achieved"] and not metrics["collisions"] for metrics in rows) else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=list(range(1, 21)))
    parser.add_argument("--engine", choices=("ros", "inprocess"), default="inprocess")
    parser.add_argument("--random-starts", action="store_true", help="and another first shape per seed")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="as of launch_swarm.py")
    parser.add_argument("--out", type=Path, help="file of runs, one line of JSON each")
    return parser


def _first(options: argparse.Namespace, seed: int) -> int:
    return seed % len(SHAPES) if options.random_starts else 0


def _settings(options: argparse.Namespace, seed: int) -> tuple[str, ...]:
    """Return what is set besides the scenario; what the command line says has the last word."""
    if not options.random_starts:
        return tuple(options.set)
    first = _first(options, seed)
    names = SHAPES[first].name, SHAPES[(first + 1) % len(SHAPES)].name
    return (*RANDOM_STARTS, f"shape.name={names[0]}", f"stages=[{{shape: {{name: {names[1]}}}}}]", *options.set)


def _key(options: argparse.Namespace, seed: int) -> str:
    return f"{options.engine}, {' '.join(_settings(options, seed))}, seed {seed}"


def _run(file: ResultFile, options: argparse.Namespace, seed: int) -> Run:
    """Make a run, or take it from the file."""
    key = _key(options, seed)
    if key not in file.records:
        words = ["--scenario", "arena", "--engine", options.engine, "--seed", str(seed), "--json"]
        words += [word for setting in _settings(options, seed) for word in ("--set", setting)]
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, str(LAUNCHER), *words, "--out", str(Path(folder) / "run")]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        if not done.stdout:
            raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {done.stderr[-2000:]}")
        file.append(key, json.loads(done.stdout))
    return Run(_first(options, seed), file.records[key])


def _print_shapes(table: Sequence[tuple[int, Sequence[Run]]]) -> None:
    print_head(
        [
            *("shape", "formed", "shortest ways [m]", "driven [m]", "driven / shortest", "settling [s]", "thesis [s]"),
            *("at goals to 1 cm [s]", "goals worse than best [mm]"),
        ]
    )
    for which, runs in table:
        shape, settled = SHAPES[which], _of(runs, "stage_settling_s", which)
        pairs = [(run.number("stage_displacement_m", which), run.number("stage_bound_m", which)) for run in runs]
        known = [(driven, bound) for driven, bound in pairs if driven is not None and bound]
        print_row(
            [
                shape.name,
                f"{len(settled)} of {len(runs)}",
                _cell([bound for _, bound in known], 2),
                _cell([driven for driven, _ in known], 2),
                _cell([driven / bound for driven, bound in known], 3),
                _cell(settled, 1),
                f"{shape.settling_s:g} for {shape.displacement_m:g} m",
                _cell(_of(runs, "stage_arrival_s", which), 1),
                _cell([MM * excess for excess in _of(runs, "stage_excess_m", which)], 1),
            ]
        )


def _print_runs(rows: Sequence[Metrics]) -> None:
    achieved, collisions = (sum(metrics[name] for metrics in rows) for name in ("achieved", "collisions"))
    images = sum(metrics["camera_images"] for metrics in rows)
    whole = [
        sum(metrics["stage_displacement_m"]) / sum(metrics["stage_bound_m"])
        for metrics in rows
        if metrics["stage_bound_m"] and None not in metrics["stage_bound_m"]
    ]
    print()
    print_head(["quantity", "value"])
    print_row(["runs achieved, collisions", f"{achieved} of {len(rows)}, {collisions}"])
    print_row(["least gap [mm]", number(MM * min(metrics["min_clearance_m"] for metrics in rows))])
    print_row(["driven / shortest, all shapes of a run", _cell(whole, 3)])
    print_row(["images; false fixes", f"{images}; {sum(metrics['camera_false_fixes'] for metrics in rows)}"])
    for name, label, factor, digits in (
        ("camera_detected_fraction", "robots in view that were found [%], least in parentheses", 100.0, 3),
        ("camera_position_rmse_m", "position of fixes, rms [mm]", MM, 2),
        ("camera_position_max_m", "the same, largest [mm]", MM, 2),
        ("camera_heading_rmse_deg", "heading of fixes, rms [deg]", 1.0, 3),
        ("camera_heading_max_deg", "the same, largest [deg]", 1.0, 2),
        ("localization_rmse_m", "where robots believe to be, rms [mm]", MM, 2),
        ("heading_rmse_deg", "where they believe to face, rms [deg]", 1.0, 3),
    ):
        values = [factor * metrics[name] for metrics in rows if metrics[name] is not None]
        print_row([label, _cell(values, digits, is_least=name == "camera_detected_fraction")])


def _of(runs: Sequence[Run], name: str, shape: int) -> list[float]:
    """Return a number of one shape from all runs that have it."""
    values = (run.number(name, shape) for run in runs)
    return [value for value in values if value is not None]


def _cell(values: Sequence[float], digits: int, *, is_least: bool = False) -> str:
    """Return mean and worst."""
    if not values:
        return "-"
    return f"{fmean(values):.{digits}f} ({(min if is_least else max)(values):.{digits}f})"


if __name__ == "__main__":
    sys.exit(main())
