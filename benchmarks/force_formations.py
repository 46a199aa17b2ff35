"""Measures formations by artificial forces, the thesis' law and the own variant, on point robots.

Fifty robots start anywhere in the field among its obstacles; positions are perfect, hellos are a tick old, radios
reach 25 m in line of sight. Prints a Markdown table: share of the runs that settled, robots inside at the end,
settling time against that of bubble packing (its longest optimal path at full speed, plus 8 %), displacement against
the least for the places that were taken, mesh irregularity.

python benchmarks/force_formations.py [--law forces] [--shapes formation_1 ...] [--seeds 20]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from force_swarm import PERIOD, Outcome, field_obstacles, field_radii, form, scattered

from mission_computer.shape import load_shape
from swarm_agent.forces.config import ForceConfig, ForceLawName
from swarm_agent.forces.registry import law_for
from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.geometry.mesh_quality import mesh_quality
from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.config import BubbleConfig, Gaps
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics.displacement import DisplacementBound, displacement_bound

SPEED, BUBBLES_OVER_BOUND, DEADLINE = 0.5, 1.08, 300.0
RADII, OBSTACLES = field_radii(), field_obstacles()
COLUMNS = (
    "settled", "inside mean / min", "settling mean / max [s]", "/ bubbles mean / max", "displacement / bound",
    "eps_t interior", "eps_t all", "eps_g", "cv area", "least gap [m]", "to obstacles [m]",
)  # fmt: skip


def main(arguments: Sequence[str]) -> None:
    """Run all seeds of all shapes and print one row per law and shape."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    names = [law.value for law in ForceLawName]
    parser.add_argument("--law", nargs="+", choices=names, default=names)
    parser.add_argument("--shapes", nargs="+", default=["formation_1", "formation_2", "formation_3", "formation_4"])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--deadline", type=float, default=DEADLINE, help="of a run [s] (default: %(default)s)")
    options = parser.parse_args(arguments)
    print(f"| law | shape | {' | '.join(COLUMNS)} |\n|{' --- |' * (len(COLUMNS) + 2)}")
    for law in options.law:
        for shape in options.shapes:
            print(
                f"| {law} | {shape} | {_row(ForceLawName(law), shape, options.seeds, options.deadline)} |", flush=True
            )


def _row(name: ForceLawName, shape: str, seeds: int, deadline: float) -> str:
    config, contour = ForceConfig(), load_shape(shape)
    goals = BubblePacking(BubbleConfig()).place(Domain(contour, OBSTACLES, RADII, Gaps()))
    assert goals is not None, "the field's roster fits every library formation"
    law = law_for(name, config.at_period(PERIOD), contour, OBSTACLES, PlanningConfig())
    outcomes = [
        form(law, config, contour, scattered(RADII, OBSTACLES, seed), RADII, OBSTACLES, deadline=deadline)
        for seed in range(seeds)
    ]
    settled = [outcome for outcome in outcomes if outcome.settled_after is not None]
    times = np.array([outcome.settled_after for outcome in settled])
    bubbles = np.array([BUBBLES_OVER_BOUND * _bound(outcome.starts, goals).longest / SPEED for outcome in settled])
    inside = np.array([outcome.inside for outcome in outcomes])
    ratios = [outcome.traveled / _bound(outcome.starts, outcome.positions).total for outcome in outcomes]
    cells = [
        f"{len(settled)}/{len(outcomes)}",
        f"{inside.mean():.1%} / {inside.min():.0%}",
        f"{times.mean():.0f} / {times.max():.0f}" if settled else "-",
        f"{(times / bubbles).mean():.2f} / {(times / bubbles).max():.2f}" if settled else "-",
        f"{np.mean(ratios):.3f}",
        *_mesh(outcomes, contour),
        f"{min(outcome.min_gap for outcome in outcomes):.2f}",
        f"{min(outcome.min_clearance for outcome in outcomes):.2f}",
    ]
    return " | ".join(cells)


def _mesh(outcomes: Sequence[Outcome], contour: FloatArray) -> list[str]:
    meshes = [mesh_quality(outcome.positions, RADII, contour) for outcome in outcomes]
    columns = ("topological_interior", "topological", "geometrical", "area_variation")
    values = [[value for mesh in meshes if (value := getattr(mesh, column)) is not None] for column in columns]
    return [f"{np.mean(column):.3f}" for column in values]


def _bound(starts: FloatArray, goals: FloatArray) -> DisplacementBound:
    """Return the optimal assignment of the starts to goals made for the same robots, row by row."""
    planners = [planner_for(OBSTACLES, float(radius), PlanningConfig()) for radius in RADII]
    costs = np.array([planner.costs(start, goals) for planner, start in zip(planners, starts, strict=True)])
    types = np.unique(RADII, return_inverse=True)[1]
    bound = displacement_bound(costs, types, types)
    assert bound is not None, "every place of the field can be reached"
    return bound


if __name__ == "__main__":
    main(sys.argv[1:])
