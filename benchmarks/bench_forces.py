"""Cost of the artificial forces on fifty robots at once, and of their parts: a 96-corner contour among six obstacles.

python benchmarks/bench_forces.py [repetitions]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import thread_time

import numpy as np
import shapely

from mission_computer.shape import load_shape
from mission_computer.shape.arena import load_arena
from swarm_agent.forces.config import LiteralForceConfig
from swarm_agent.forces.force_law import Others
from swarm_agent.forces.literal_law import LiteralLaw
from swarm_agent.forces.obstacle_integral import ObstacleIntegral
from swarm_msgs_py.geometry.contour_integrals import ContourIntegrals
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.robots import THESIS_TYPES

ROBOTS = 50
BATCH = 20
"""Evaluations per measurement, so that the clock's resolution does not count."""
LARGE = 1_000_000


def main(repetitions: int) -> None:
    """Print the distribution of the cost of one evaluation for all robots."""
    contour = load_shape("formation_1")
    obstacles = tuple(obstacle.polygon() for obstacle in load_arena("arena_main").obstacles)
    candidates = rng_for(0, "bench-forces").uniform(-30.0, 30.0, (2 * ROBOTS, 2))
    keep_out = shapely.union_all([shapely.Polygon(obstacle).buffer(1.0) for obstacle in obstacles])
    positions = candidates[~shapely.contains_xy(keep_out, *candidates.T)][:ROBOTS]
    radii = np.array([THESIS_TYPES[robot % 3].coverage_radius_m for robot in range(ROBOTS)])
    others = Others.each_other(positions, radii)
    config = LiteralForceConfig()
    integrals = ContourIntegrals(contour)
    walls = ObstacleIntegral(obstacles, config.obstacle_gap_min_m)
    law = LiteralLaw(config, contour, obstacles, 0.1)
    parts: dict[str, Callable[[], object]] = {
        "attraction": lambda: integrals.at(positions).attraction,
        "repulsion": lambda: integrals.at(positions).repulsion,
        "transition": lambda: integrals.at(positions).transition,
        "signed distance": lambda: integrals.at(positions).signed_distances,
        "obstacles": lambda: walls.at(positions, radii),
        "all five forces": lambda: law.evaluate(positions, radii, others),
        "one robot of them": lambda: law.evaluate(positions[:1], radii[:1], Others(positions, radii, others.heard[:1])),
    }
    # A process that has once freed a large array keeps its heap; a fresh one gives it back after every evaluation.
    np.ones(LARGE)
    print(f"{ROBOTS} robots, {len(contour)} corners, {sum(map(len, obstacles))} corners of obstacles\n")
    print("| part | p10 [us] | median [us] | p90 [us] |\n| --- | --- | --- | --- |")
    for name, part in parts.items():
        micros = 1e6 * np.array([_cost(part) for _ in range(repetitions)])
        print(f"| {name} | " + " | ".join(f"{cost:.0f}" for cost in np.percentile(micros, (10, 50, 90))) + " |")


def _cost(part: Callable[[], object]) -> float:
    began = thread_time()
    for _ in range(BATCH):
        part()
    return (thread_time() - began) / BATCH


if __name__ == "__main__":
    main(*(int(word) for word in (sys.argv[1:] or ["100"])))
