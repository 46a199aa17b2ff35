"""Hexagonal lattices laid over a region in several ways, as starts for what makes them fit its contour."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.partition.rounding import direction, on_grid
from swarm_msgs_py.types import FloatArray

HEIGHT = math.sqrt(0.75)  # of an equilateral triangle
SIXTH = np.pi / 3.0  # a hexagonal lattice looks the same after this turn
# Which point of the lattice lies on the origin, in lattice vectors: a site, the middle of a triangle, that of a side.
_PHASES = ((0.0, 0.0), (1.0 / 3.0, 1.0 / 3.0), (0.5, 0.0))


def lattice_starts(region: BaseGeometry, spacing: float, count: int, starts: int) -> Iterator[FloatArray]:
    """Yield starts, each the `count` points of a lattice that are deepest in the region, deepest first.

    Parameters
    ----------
    region : shapely geometry
        Around the origin [m].
    spacing : float
        Between neighbors of the lattice [m].
    count : int
        Points per start.
    starts : int
        How many: their directions are spread evenly over the sixth of a turn after which lattices repeat.

    Yields
    ------
    (count, 2) array
        Points [m]; the last may lie a little outside.
    """
    # So far out that there are enough points, however little of its surroundings the region fills.
    reach = max(abs(bound) for bound in region.bounds) + (1.0 + np.sqrt(count)) * spacing
    half = int(np.ceil(2.0 * reach / spacing))
    steps = np.arange(-half, half + 1)
    first, second = (grid.ravel().astype(np.float64) for grid in np.meshgrid(steps, steps))
    for start in range(starts):
        phase = _PHASES[start % len(_PHASES)]
        along, up = first + phase[0], second + phase[1]
        x, y = spacing * (along + 0.5 * up), spacing * HEIGHT * up
        turn = start * SIXTH / starts
        cosine, sine = direction(turn)
        points = np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
        points = points[(np.abs(points) < reach).all(axis=1)]
        sites = shapely.points(points)
        outside = shapely.distance(region, sites)
        depths = np.where(outside > 0.0, -outside, shapely.distance(region.boundary, sites))
        yield points[np.argsort(-on_grid(depths), kind="stable")[:count]]
