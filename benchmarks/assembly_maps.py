"""Steps, success and planning time of assemblies on the four maps of the paper, or on generated structures.

PYTHONPATH=scripts python benchmarks/assembly_maps.py [--mode timed|tabu] [--seeds N] [--maps 1 2 3 4] [--cells M]
[--outlines block ring cross] [--docks genderless gendered] [--first-seed S]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from time import thread_time

import numpy as np

from mission_computer.assembly.generated import Outline, generate_problem
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_guideposts, plan_with_timed_paths
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.tabu_search import TabuLimits
from mission_computer.assembly.travel import distance_only_dispatch
from studies.assembly_runs import assemble_decentralized
from swarm_msgs_py.assembly.docking import docked_groups
from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import AssemblyError
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
    options = parser.parse_args(arguments)
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    genders = [Gender(docks) for docks in options.docks]
    outlines = [Outline(outline) for outline in options.outlines]
    print("| structure | docks | success | steps mean (max) | longest travel | found", end=" ")
    print("| planning [s] mean (max) | control |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    rows = _generated(outlines, options.cells, genders, seeds) if options.cells else _maps(options.maps, genders, seeds)
    results = [_row(name, gender, problems, PLANNERS[options.mode]) for name, gender, problems in rows]
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


def _row(name: str, gender: Gender, problems: dict[int, AssemblyProblem], planner: Planner) -> bool:
    """Print one row; return whether every assembly was legal and complete."""
    steps, travels, found, seconds = [], [], [], []
    for seed, problem in problems.items():
        before = thread_time()
        try:
            plan = planner(problem, seed)
        except AssemblyError as error:
            print(f"{error}")
            continue
        seconds.append(thread_time() - before)
        found.append(plan.feasible)
        travels.append(plan.dispatch.longest_travel(problem))
        if plan.paths is not None:
            audit = audit_assembly(problem, plan.dispatch, plan.paths.cells)
        else:
            audit = assemble_decentralized(problem, plan, seed).audit
        if audit.is_legal_and_complete:
            steps.append(audit.steps)
        else:
            print(f"{name}, seed {seed}: {audit.violations[0]}")
    print(
        f"| {name} | {gender.value} | {len(steps)} of {len(problems)} | {_mean(steps):.2f} ({max(steps, default=0)})"
        f" | {_mean(travels):.1f} | {_mean(found):.0f} | {_mean(seconds):.2f} ({max(seconds, default=0.0):.2f})"
        f" | {_control(next(iter(problems.values())))} pieces |",
        flush=True,
    )
    return len(steps) == len(problems)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")


def _control(problem: AssemblyProblem) -> int:
    """Return the pieces that the dispatch of least travel leaves, which knows nothing of docks."""
    layouts = distance_only_dispatch(problem).layouts(problem)
    return len(docked_groups(dict(zip(Structure(problem.targets).cells, layouts, strict=True)), problem.gender))


if __name__ == "__main__":
    raise SystemExit(main())
