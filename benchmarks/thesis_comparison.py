"""Sets the methods of a Monte Carlo batch against each other and against the thesis: prints Markdown tables.

python benchmarks/thesis_comparison.py FOLDER

FOLDER is what ``scripts/monte_carlo.py`` wrote. The first table has a row per shape and method: means with the half
width of their 95 % confidence interval. The second has the ratios of the methods to bubble packing on equal random
starts: geometric means of the runs' ratios with their 95 % interval (Student's t of the logarithms), beside the ratios
in the thesis' tables 4.5 to 4.8. The third asks for each metric whether the method that the thesis found the worst
(table 4.4) is the worst here.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))

from pyarrow import ArrowInvalid, parquet
from tables import print_head, print_row

from batches.cli import RUNS
from batches.estimates import Estimate, estimate, paired_difference

Run = Mapping[str, Any]
Runs = dict[tuple[str, str], dict[int, Run]]
"""By shape and method, then by seed."""

FORCES, LITERAL, BUBBLES, FRACTALS = "forces", "forces-literal", "bubble-packing", "fractals"
DISPLACEMENT, SETTLING = "total_displacement_m", "settling_time_s"
TOPOLOGICAL, GEOMETRICAL = "mesh_topological", "mesh_geometrical"
LABELS = {DISPLACEMENT: "displacement", SETTLING: "settling", TOPOLOGICAL: "eps_t", GEOMETRICAL: "eps_g"}
THESIS: dict[str, dict[str, tuple[float, float, float, float]]] = {
    "formation_1": {"A": (1889, 164, 2.54, 0.62), "B": (1750, 151, 2.44, 0.67), "C": (1762, 153, 3.14, 0.92)},
    "formation_2": {"A": (1611, 153, 2.95, 0.73), "B": (1550, 141, 2.84, 0.77), "C": (1522, 140, 3.24, 1.12)},
    "formation_3": {"A": (1432, 126, 2.23, 0.45), "B": (1330, 115, 2.14, 0.52), "C": (1350, 112, 3.15, 0.89)},
    "formation_4": {"A": (1578, 142, 2.15, 0.56), "B": (1345, 112, 2.34, 0.66), "C": (1321, 121, 3.23, 1.05)},
}
"""Thesis tables 4.5 to 4.8, one run each: the numbers of `LABELS` by method (A forces, B bubbles, C fractals)."""
OF_THESIS = {FORCES: "A", LITERAL: "A", BUBBLES: "B", FRACTALS: "C"}
WORST = {DISPLACEMENT: "A", SETTLING: "A", TOPOLOGICAL: "C", GEOMETRICAL: "C"}
"""Thesis table 4.4."""

MEANS: dict[str, Callable[[Run], float | None]] = {
    "displacement / bound": lambda run: run["displacement_ratio"],
    "settling / bottleneck": lambda run: _over(run[SETTLING], run["bottleneck_time_s"]),
    "eps_t interior": lambda run: run["mesh_topological_interior"],
    "eps_t all": lambda run: run[TOPOLOGICAL],
    "eps_g": lambda run: run[GEOMETRICAL],
    "area variation": lambda run: run["cell_area_variation"],
    "covered": lambda run: run["covered_fraction"],
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; return 2 if there is no batch in the folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="of a batch of scripts/monte_carlo.py")
    file = parser.parse_args(arguments).folder / RUNS
    try:
        rows = parquet.read_table(file).to_pylist()
    except (OSError, ArrowInvalid) as error:
        print(
            f"error: {file}: no table of runs ({' '.join(str(error).split())}); give a batch's folder", file=sys.stderr
        )
        return 2
    runs: Runs = {}
    for row in sorted(rows, key=lambda row: row["seed"]):
        runs.setdefault((row["shape"], row["method"]), {})[row["seed"]] = row
    _print_means(runs)
    _print_ratios(runs)
    _print_ranking(runs)
    return 0


def _over(value: float | None, base: float | None) -> float | None:
    return value / base if value is not None and base else None


def _print_means(runs: Runs) -> None:
    print("\n### Methods\n")
    print_head(["shape", "method", "runs", "achieved", "settled", "collisions", "least gap [m]", *MEANS])
    for (shape, method), by_seed in sorted(runs.items()):
        found = list(by_seed.values())
        clearances = [run["min_clearance_m"] for run in found if run["min_clearance_m"] is not None]
        print_row(
            [
                *(shape, method, str(len(found)), str(sum(run["achieved"] for run in found))),
                str(sum(run[SETTLING] is not None for run in found)),
                str(sum(run["collisions"] or 0 for run in found)),
                f"{min(clearances):.3f}" if clearances else "-",
                *(_mean(found, column) for column in MEANS.values()),
            ]
        )


def _mean(found: Sequence[Run], column: Callable[[Run], float | None]) -> str:
    known = estimate([value for value in map(column, found) if value is not None])
    if known is None:
        return "-"
    return f"{known.mean:.3f}" if known.high is None else f"{known.mean:.3f} ± {known.high - known.mean:.3f}"


def _print_ratios(runs: Runs) -> None:
    """Print ratios to bubble packing, ours with their intervals and the thesis' in parentheses."""
    shapes = sorted({shape for shape, _ in runs if (shape, BUBBLES) in runs})
    print("\n### Ratios to bubble packing (in parentheses: of the thesis' tables 4.5 to 4.8)\n")
    print_head(["method", "metric", *shapes])
    for method in sorted({method for _, method in runs} - {BUBBLES}):
        for metric, label in LABELS.items():
            print_row([method, label, *(_ratio_cell(runs, shape, method, metric) for shape in shapes)])


def _ratio_cell(runs: Runs, shape: str, method: str, metric: str) -> str:
    ratio = _ratio(runs, shape, method, BUBBLES, metric)
    if ratio is None:
        return "-"
    cell = f"{ratio.mean:.3f}" if ratio.low is None else f"{ratio.mean:.3f} [{ratio.low:.3f}, {ratio.high:.3f}]"
    if shape in THESIS and method in OF_THESIS:
        place = list(LABELS).index(metric)
        cell += f" ({THESIS[shape][OF_THESIS[method]][place] / THESIS[shape]['B'][place]:.2f})"
    return cell


def _ratio(runs: Runs, shape: str, method: str, base: str, metric: str) -> Estimate | None:
    """Return the geometric mean of a metric's ratio over the seeds that both methods have, with its interval."""
    first, second = runs.get((shape, base), {}), runs.get((shape, method), {})
    seeds = [seed for seed in second if seed in first and first[seed][metric] and second[seed][metric]]
    logs = [[math.log(by_seed[seed][metric]) for seed in seeds] for by_seed in (first, second)]
    found = paired_difference(*logs)
    if found is None:
        return None
    low, high = (None if bound is None else math.exp(bound) for bound in (found.low, found.high))
    return Estimate(math.exp(found.mean), found.deviation, low, high, math.exp(found.worst), found.count)


def _print_ranking(runs: Runs) -> None:
    """Print for each metric and shape whether the method that the thesis found the worst is worse than both others."""
    shapes = sorted({shape for shape, _ in runs} & THESIS.keys())
    print("\n### The worst of forces (A), bubbles (B) and fractals (C), thesis table 4.4\n")
    print_head(["metric", "thesis", "forces are", *shapes])
    for forces in (FORCES, LITERAL):
        methods = {"A": forces, "B": BUBBLES, "C": FRACTALS}
        if not any((shape, forces) in runs for shape in shapes):
            continue
        for metric, worst in WORST.items():
            cells = [_verdict(runs, shape, metric, worst, methods) for shape in shapes]
            print_row([LABELS[metric], worst, forces, *cells])


def _verdict(runs: Runs, shape: str, metric: str, worst: str, methods: Mapping[str, str]) -> str:
    """Return "holds" if both ratios to the others are above 1 with their intervals, else which is not."""
    others = [name for name in methods if name != worst]
    ratios = {name: _ratio(runs, shape, methods[worst], methods[name], metric) for name in others}
    if any(ratio is None or ratio.low is None or ratio.high is None for ratio in ratios.values()):
        return "-"
    words = []
    for name, ratio in ratios.items():
        assert ratio is not None and ratio.low is not None and ratio.high is not None  # noqa: PT018 - asked above
        if ratio.high < 1.0:
            words.append(f"{name} is worse, {worst}/{name} = {ratio.mean:.3f}")
        elif ratio.low <= 1.0:
            words.append(f"{name} as bad, {worst}/{name} = {ratio.mean:.3f}")
    return "; ".join(words) or "holds"


if __name__ == "__main__":
    sys.exit(main())
