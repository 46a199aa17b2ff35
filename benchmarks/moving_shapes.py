"""How well a swarm follows a shape that moves, and shapes one after the other: prints Markdown tables.

python benchmarks/moving_shapes.py [--methods M ...] [--motions NAME ...] [--seeds S ...] [--scenario NAME] [--out FILE]
python benchmarks/moving_shapes.py --sequence [...]

In-process, mass-damper. Motions begin when the first shape stands; values are means over the seeds, with the worst in
parentheses. With ``--sequence`` the three shapes of the thesis' table 4.9 are formed in turn, and their displacements
and settling times summed up. With ``--out`` finished runs are kept, and are not run again.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from result_file import open_results
from tables import number, print_head, print_row

from bringup.resolution import resolve
from bringup.results import formation_metrics
from bringup.scenario_file import Override, load_scenario, method_overrides, parse_assignment, shape_override
from studies.campaign import ResultFile
from studies.headless_mission import ENGINE, run_to_verdict
from swarm_msgs_py.errors import ConfigError, ShapeError

Metrics = dict[str, Any]

MOTIONS: dict[str, tuple[str, str]] = {
    "formation_3 to formation_1, 60 s": ("formation_3", "{shape: {name: formation_1}, over_s: 60.0}"),
    "formation_3 to formation_1, 20 s": ("formation_3", "{shape: {name: formation_1}, over_s: 20.0}"),
    "iso_1_circle to iso_2_rect, 60 s": ("iso_1_circle", "{shape: {name: iso_2_rect}, over_s: 60.0}"),
    "iso_1_circle to iso_2_rect, 20 s": ("iso_1_circle", "{shape: {name: iso_2_rect}, over_s: 20.0}"),
    "shifted by 9 m, 40 s": ("formation_1", "{translate_m: [8.0, 4.0], over_s: 40.0}"),
    "turned by 90 degrees, 90 s": ("formation_1", "{rotate_deg: 90.0, over_s: 90.0}"),
    "1.2 times as large, 40 s": ("formation_1", "{scale: 1.2, over_s: 40.0}"),
    "split in two, 40 s": ("formation_1", "{split: {gap_m: 4.0}, over_s: 40.0}"),
    "joined again, 40 s": ("formation_1", "{split: {gap_m: 4.0}}, {join: true, over_s: 40.0}"),
}
"""First shape and stages by name."""

SEQUENCE = ("formation_1", "{shape: {name: formation_2}}, {shape: {name: formation_4}}")
DURATION = "duration_s=700"


@dataclass(frozen=True)
class Column:
    """One number of the table of motions."""

    value: Callable[[Metrics], float | None]
    digits: int
    worst: Callable[[Sequence[float]], float] = max


COLUMNS: dict[str, Column] = {
    "latency [s]": Column(lambda m: m["morph_latency_s"], 2),
    "outside [%]": Column(
        lambda m: None if m["morph_outside_fraction"] is None else 100.0 * m["morph_outside_fraction"], 2
    ),
    "recovery [s]": Column(lambda m: m["morph_recovery_s"], 2),
    "least clearance [m]": Column(lambda m: m["min_clearance_m"], 3, min),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; return 1 if a run was not achieved, or robots collided."""
    options = _parser().parse_args(arguments)
    try:
        file = open_results(options.out)
        runs = _Runs(options, file)
        rows = _sequence(options, runs) if options.sequence else _motions(options, runs)
    except (ConfigError, ShapeError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if warning := file.warning(runs.keys):
        print(f"\n**{warning}**")
    return 0 if all(metrics["achieved"] and not metrics["collisions"] for metrics in rows) else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--scenario", default="formation-50-ideal", help="robots, radio, positions (default: %(default)s)"
    )
    parser.add_argument("--methods", nargs="+", default=["bubble-packing", "voronoi", "forces"], metavar="M")
    parser.add_argument("--motions", nargs="+", default=list(MOTIONS), choices=MOTIONS, metavar="NAME")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--sequence", action="store_true", help="three shapes in turn, at rest in each, instead")
    parser.add_argument("--out", type=Path, help="file of runs, one line of JSON each")
    return parser


class _Runs:
    """Makes runs, or takes them from the file.

    Parameters
    ----------
    options : argparse.Namespace
    file : ResultFile

    Attributes
    ----------
    keys : list of str
        Of the runs asked for.
    """

    def __init__(self, options: argparse.Namespace, file: ResultFile) -> None:
        self._options = options
        self._file = file
        self.keys: list[str] = []

    def of(self, method: str, shape: str, stages: str) -> list[Metrics]:
        """Return the metrics of all seeds."""
        found = []
        for seed in self._options.seeds:
            key = f"{self._options.scenario}, {shape}, {stages}, {method}, seed {seed}"
            if key not in self._file.records:
                self._file.append(key, self._run(method, shape, stages, seed))
            self.keys.append(key)
            # As the file has it: tuples have become lists whether or not the run is an old one.
            found.append(json.loads(json.dumps(self._file.records[key])))
        return found

    def _run(self, method: str, shape: str, stages: str, seed: int) -> Metrics:
        overrides = (
            shape_override(shape),
            *method_overrides(method),
            Override("--seeds", "seed", seed),
            *map(parse_assignment, (f"stages=[{stages}]", DURATION, "sim.physics.backend=massdamper")),
        )
        scenario = resolve(*load_scenario(self._options.scenario, overrides))
        return asdict(formation_metrics(scenario, ENGINE, run_to_verdict(scenario)))


def _motions(options: argparse.Namespace, runs: _Runs) -> list[Metrics]:
    print_head(["motion", "method", "runs", "achieved", "collisions", *COLUMNS])
    rows: list[Metrics] = []
    for motion in options.motions:
        for method in options.methods:
            found = runs.of(method, *MOTIONS[motion])
            cells = [_cell(list(map(column.value, found)), column.digits, column.worst) for column in COLUMNS.values()]
            print_row([motion, method, *_outcome(found), *cells])
            rows += found
    return rows


def _sequence(options: argparse.Namespace, runs: _Runs) -> list[Metrics]:
    print_head(["method", "runs", "achieved", "collisions", "displacement [m]", "settling [s]", "per shape [s]"])
    rows: list[Metrics] = []
    for method in options.methods:
        found = runs.of(method, *SEQUENCE)
        settled = [metrics["stage_settling_s"] for metrics in found if None not in metrics["stage_settling_s"]]
        driven = [sum(metrics["stage_displacement_m"]) for metrics in found]
        per_shape = " / ".join(number(fmean(times)) for times in zip(*settled, strict=True))
        cells = [_cell(driven, 1), _cell([sum(times) for times in settled], 1), per_shape]
        print_row([method, *_outcome(found), *cells])
        rows += found
    return rows


def _outcome(rows: Sequence[Metrics]) -> list[str]:
    achieved, collisions = (sum(metrics[name] for metrics in rows) for name in ("achieved", "collisions"))
    return [str(len(rows)), str(achieved), str(collisions)]


def _cell(values: Sequence[float | None], digits: int, worst: Callable[[Sequence[float]], float] = max) -> str:
    """Return mean and worst, and of how many runs if some do not have the number."""
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    some = "" if len(known) == len(values) else f", {len(known)} of {len(values)} runs"
    return f"{fmean(known):.{digits}f} ({worst(known):.{digits}f}{some})"


if __name__ == "__main__":
    sys.exit(main())
