"""Shapes in an orientation drawn from the seed."""

from __future__ import annotations

from dataclasses import replace

import shapely

from bringup.resolution import contour_of
from bringup.scenario import Scenario
from swarm_msgs_py.randomness import rng_for

DRAWS_MAX = 100
"""After so many orientations that do not fit, the last one is left, for the run to be refused with the reason."""


def turned(scenario: Scenario) -> Scenario:
    """Return a scenario, written out, with its shape turned about the center of area to where it fits.

    The angle is the first of a sequence drawn from the seed at which the shape is in the arena and clear of obstacles.
    It depends on seed, shape and map, not on the method, as the starts do not.
    """
    bounds = scenario.map.bounds_m
    assert bounds is not None  # written out
    arena, rng = shapely.box(*bounds), rng_for(scenario.seed, "batch-turn", 0)
    obstacles = shapely.union_all([shapely.Polygon(obstacle.polygon()) for obstacle in scenario.map.obstacles])
    for _ in range(DRAWS_MAX):
        turn_deg = float(rng.uniform(0.0, 360.0))
        found = replace(scenario, shape=replace(scenario.shape, rotation_deg=turn_deg))
        shape = shapely.Polygon(contour_of(found))
        if arena.contains(shape) and not shape.intersects(obstacles):
            break
    return found
