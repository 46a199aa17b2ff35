"""Steps, success and planning time of assemblies on the four maps of the paper, or on generated structures.

PYTHONPATH=scripts python benchmarks/assembly_maps.py [--mode timed|tabu] [--seeds N] [--maps 1 2 3 4] [--cells M]
[--outlines block ring cross] [--docks genderless gendered] [--first-seed S] [--out FILE]

With ``--out`` finished runs are kept, and are not made again.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
from result_file import open_results
from tables import print_head, print_row

from mission_computer.assembly.generated import Outline, generate_problem
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_guideposts, plan_with_timed_paths
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.tabu_search import TabuLimits
from mission_computer.assembly.travel import distance_only_dispatch
from studies.assembly_runs import assemble_decentralized
from studies.campaign import ResultFile
from swarm_msgs_py.assembly.docking import docked_groups
from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import AssemblyError, ConfigError
from swarm_sim.metrics.assembly import audit_assembly

Planner = Callable[[AssemblyProblem, int], AssemblyPlan]
PLANNERS: dict[str, Planner] = {
    "timed": lambda problem, seed: plan_with_timed_paths(problem, seed, TimedPlannerLimits()),
    "tabu": lambda problem, seed: plan_with_guideposts(problem, seed, TabuLimits()),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and return the exit code: 1 if an assembly was not legal and complete."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mode", choices=sorted(PLANNERS), default="timed", help="default: %(default)s")
    parser.add_argument("--seeds", type=int, default=20, help="runs per row (default: %(default)s)")
    parser.add_argument("--maps", type=int, nargs="+", default=[1, 2, 3, 4], help="default: all four")
    parser.add_argument("--cells", type=int, help="generated structures of that many cells instead of maps")
    parser.add_argument("--outlines", nargs="+", default=[one.value for one in Outline], help="default: all")
    parser.add_argument("--docks", nargs="+", default=[one.value for one in Gender], help="default: both")
    parser.add_argument("--first-seed", type=int, default=0, help="to go on with (default: %(default)s)")
    parser.add_argument("--out", type=Path, help="file of runs, one line of JSON each")
    options = parser.parse_args(arguments)
    try:
        file = open_results(options.out)
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    genders = [Gender(docks) for docks in options.docks]
    outlines = [Outline(outline) for outline in options.outlines]
    columns = (
        "structure",
        "docks",
        "success",
        "steps mean (max)",
        "longest travel",
        "found",
        "planning [s] mean (max)",
    )
    print_head([*columns, "control"])
    rows = _generated(outlines, options.cells, genders, seeds) if options.cells else _maps(options.maps, genders, seeds)
    results = [_row(name, gender, problems, options.mode, file) for name, gender, problems in rows]
    return 0 if all(results) else 1


Row = tuple[str, Gender, dict[int, AssemblyProblem]]
"""Structure, docks, and a problem per seed."""


def _maps(numbers: Sequence[int], genders: Sequence[Gender], seeds: Sequence[int]) -> Iterator[Row]:
    for number in numbers:
        for gender in genders:
            yield f"map_{number}", gender, dict.fromkeys(seeds, load_problem(f"map_{number}", gender))


def _generated(
    outlines: Sequence[Outline], cells: int, genders: Sequence[Gender], seeds: Sequence[int]
) -> Iterator[Row]:
    for outline in outlines:
        for gender in genders:
            problems = {seed: generate_problem(outline, cells, gender, seed) for seed in seeds}
            yield f"{outline.value}-{cells}", gender, problems


def _row(name: str, gender: Gender, problems: dict[int, AssemblyProblem], mode: str, file: ResultFile) -> bool:
    """Print one row; return whether every assembly was legal and complete."""
    runs: list[dict[str, Any]] = []
    for seed, problem in problems.items():
        key = f"{mode}, {name}, {gender.value}, seed {seed}"
        if key not in file.records:
            file.append(key, _run(problem, seed, PLANNERS[mode]))
        runs.append(dict(file.records[key]))
        if runs[-1]["failure"]:
            print(f"{name}, seed {seed}: {runs[-1]['failure']}")
    planned = [run for run in runs if run["seconds"] is not None]
    steps = [run["steps"] for run in runs if not run["failure"]]
    seconds = [run["seconds"] for run in planned]
    print_row(
        [
            *(name, gender.value, f"{len(steps)} of {len(runs)}"),
            f"{_mean(steps):.2f} ({max(steps, default=0)})",
            f"{_mean([run['travel'] for run in planned]):.1f}",
            f"{_mean([run['found'] for run in planned]):.0f}",
            f"{_mean(seconds):.2f} ({max(seconds, default=0.0):.2f})",
            f"{_control(next(iter(problems.values())))} pieces",
        ]
    )
    return len(steps) == len(problems)


def _run(problem: AssemblyProblem, seed: int, planner: Planner) -> dict[str, Any]:
    """Return steps, travel, found dispatches and planning time of a run, and why it failed: empty if it did not."""
    before = thread_time()
    try:
        plan = planner(problem, seed)
    except AssemblyError as error:
        return {"failure": str(error), "seconds": None}
    seconds = thread_time() - before
    if plan.paths is not None:
        audit = audit_assembly(problem, plan.dispatch, plan.paths.cells)
    else:
        audit = assemble_decentralized(problem, plan, seed).audit
    return {
        "failure": ""
        if audit.is_legal_and_complete
        else "; ".join(audit.violations) or "the structure is not complete",
        "seconds": seconds,
        "found": plan.feasible,
        "travel": plan.dispatch.longest_travel(problem),
        "steps": audit.steps,
    }


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _control(problem: AssemblyProblem) -> int:
    """Return the pieces that the dispatch of least travel leaves, which knows nothing of docks."""
    layouts = distance_only_dispatch(problem).layouts(problem)
    return len(docked_groups(dict(zip(Structure(problem.targets).cells, layouts, strict=True)), problem.gender))


if __name__ == "__main__":
    raise SystemExit(main())
