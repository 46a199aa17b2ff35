"""What the bottleneck objective costs in total displacement, and gains in the longest path.

Fifty robots of three types from random starts in the rough arena to the four formations; costs are lengths of shortest
paths around the arena's obstacles, as robots offer them. No run is simulated: only the assignments are compared.

PYTHONPATH=scripts python benchmarks/assignment.py [--seeds N]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import thread_time

import numpy as np
from scipy.optimize import linear_sum_assignment

from bringup.cross_checks import first_plan
from bringup.layout import make_scene, robot_types, walls
from bringup.resolution import contour_of, resolve
from bringup.scenario import Scenario
from bringup.scenario_file import Override, load_scenario
from swarm_agent.decision.assignment import assign
from swarm_agent.decision.path_costs import STEP_M, PathCosts
from swarm_msgs_py.messages.bodies import CostRow, Objective, Plan
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import NodeId

SHAPES = ("formation_1", "formation_2", "formation_3", "formation_4")
TARGET = 1.10  # total displacement of the bottleneck assignment / least total


@dataclass(frozen=True)
class Comparison:
    """Both objectives on one set of rows; lengths in meters."""

    total_m: float  # least total
    total_longest_m: float  # longest path of that assignment
    bottleneck_m: float  # total of the bottleneck assignment
    longest_m: float  # its longest path
    apart_m: float  # its total if every type kept to its own least longest path
    is_optimal: bool  # whether each assignment of some type has a path that long
    seconds: float  # for the bottleneck assignment


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and return the exit code: 1 if a longest path is not optimal, or a total is above the target."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=50, help="random starts per shape (default: %(default)s)")
    seeds = parser.parse_args(arguments).seeds
    print("| shape | starts | total / least, mean (max) | longest / that of the least total, mean (min) |", end=" ")
    print("each type apart: total / least | optimal | solved in [ms] |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    results = {shape: _compare_all(shape, seeds) for shape in SHAPES}
    for shape, found in results.items():
        totals = np.array([one.bottleneck_m / one.total_m for one in found])
        longest = np.array([one.longest_m / one.total_longest_m for one in found])
        apart = np.array([one.apart_m / one.total_m for one in found])
        optimal = sum(one.is_optimal for one in found)
        print(
            f"| {shape} | {len(found)} | {totals.mean():.3f} ({totals.max():.3f}) "
            f"| {longest.mean():.3f} ({longest.min():.3f}) | {apart.mean():.3f} ({apart.max():.3f}) "
            f"| {optimal} of {len(found)} | {1e3 * np.median([one.seconds for one in found]):.1f} |"
        )
    everything = [one for found in results.values() for one in found]
    reached = all(one.is_optimal and one.bottleneck_m <= TARGET * one.total_m for one in everything)
    print(f"\ntotal <= {TARGET} x least, and longest path optimal: {'yes' if reached else 'no'}")
    return 0 if reached else 1


def _compare_all(shape: str, seeds: int) -> list[Comparison]:
    override = Override("benchmarks/assignment.py", "shape.name", shape)
    scenario = resolve(*load_scenario("formation-50", (override,)))
    plan = first_plan(scenario, contour_of(scenario), Roster.of(robot_types(scenario)), walls(scenario))
    return [_compare(replace(scenario, seed=seed), plan) for seed in range(1, seeds + 1)]


def _compare(scenario: Scenario, plan: Plan) -> Comparison:
    """Return both assignments of one random start."""
    rows = _rows(scenario, plan)
    wanting = tuple(replace(row, objective=Objective.BOTTLENECK) for row in rows)
    least = _lengths(rows, assign(rows))
    began = thread_time()
    taken = assign(wanting)
    seconds = thread_time() - began
    bottleneck = _lengths(rows, taken)
    kinds = sorted({row.robot_type for row in rows})
    by_type = [tuple(row for row in wanting if row.robot_type == kind) for kind in kinds]
    apart = sum(_lengths(group, assign(group)).sum() for group in by_type)
    is_optimal = any(_needs(group, bottleneck.max()) for group in by_type)
    return Comparison(least.sum(), least.max(), bottleneck.sum(), bottleneck.max(), float(apart), is_optimal, seconds)


def _rows(scenario: Scenario, plan: Plan) -> tuple[CostRow, ...]:
    """Return what the robots offer where they start."""
    paths = {kind: PathCosts(kind, scenario.agent.planning) for kind in sorted(set(robot_types(scenario)), key=str)}
    return tuple(
        CostRow(1, NodeId(robot.id), robot.type.type, 1, paths[robot.type].of(0, plan, np.array(robot.position)))
        for robot in make_scene(scenario).robots
    )


def _lengths(rows: Sequence[CostRow], taken: dict[NodeId, int]) -> np.ndarray:
    return np.array([row.costs[taken[row.robot]] for row in rows]) * STEP_M


def _needs(rows: Sequence[CostRow], longest_m: float) -> bool:
    """Return whether no assignment of these robots does without a path of that length (another way to find it)."""
    is_long = np.array([row.costs for row in rows]) >= round(longest_m / STEP_M)
    return bool(is_long[linear_sum_assignment(is_long)].any())


if __name__ == "__main__":
    raise SystemExit(main())
