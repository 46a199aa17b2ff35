"""Where robots would stand that know nothing of a method: what an irregularity is to be compared with.

A number of the mesh says little by itself, because every contour spoils some cells. Two controls frame it: a hexagonal
lattice cut out by the shape, perfect within and careless of the contour, and points drawn evenly from the shape.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from swarm_msgs_py.partition.lattice_starts import lattice_starts
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.types import FloatArray

DIRECTIONS = 3  # in which the lattice is laid over the shape
SHRINKINGS = np.arange(1.0, 0.8, -0.005)  # of the lattice, until as many of its points as there are robots fit inside


def hexagonal_lattices(contour: FloatArray, count: int) -> Iterator[FloatArray]:
    """Yield points of a hexagonal lattice that lie inside a shape, in up to `DIRECTIONS` directions.

    Parameters
    ----------
    contour : (k, 2) array
        The shape [m].
    count : int
        Number of points.

    Yields
    ------
    (count, 2) array
        The deepest points of a lattice that is as wide as it can be [m].
    """
    frame = OwnFrame(contour)
    shape = shapely.Polygon(frame.enter(contour))
    spacing = float(np.sqrt(2.0 * shape.area / (np.sqrt(3.0) * count)))  # spec 9.2
    for number in range(DIRECTIONS):
        for shrinking in SHRINKINGS.tolist():
            *_, points = lattice_starts(shape, shrinking * spacing, count, number + 1)
            if shapely.contains_xy(shape, points).all():
                yield frame.leave(points)
                break


def random_points(contour: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    """Return points drawn evenly from a shape, (count, 2) [m].

    Parameters
    ----------
    contour : (k, 2) array
        The shape [m].
    count : int
        Number of points.
    rng : numpy.random.Generator
    """
    shape, points = shapely.Polygon(contour), np.empty((0, 2))
    low, high = contour.min(axis=0), contour.max(axis=0)
    while len(points) < count:
        drawn = rng.uniform(low, high, size=(count, 2))
        points = np.concatenate([points, drawn[shapely.contains_xy(shape, drawn)]])
    return points[:count]
