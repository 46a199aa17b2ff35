"""Points in and on a solid, from its inside test alone."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import FloatArray

BATCHES_MAX = 200  # of samples that find nothing until a shape counts as empty
STEPS = 256  # along a line across the bounding sphere: thinner parts than 1/256 of it may be missed
POINTS_MAX, LINES_MAX = 1 << 18, 1 << 10  # looked at in one go, to bound the memory
BISECTIONS = 40  # until a crossing is known to the last bits


def interior_points(solid: Solid, count: int, rng: np.random.Generator) -> FloatArray:
    """Return `count` points drawn uniformly from the inside of a solid, (count, 3) [m].

    Raises
    ------
    ShapeError
        If hardly any of its bounding box is inside.
    """
    lower, upper = solid.bounds
    found: list[FloatArray] = []
    missing = count
    vain = 0
    while vain < BATCHES_MAX:
        points = lower + (upper - lower) * rng.random((min(max(2 * missing, 1024), POINTS_MAX), 3))
        points = points[solid.contains(points)][:missing]
        found.append(points)
        missing -= len(points)
        vain += not len(points)
        if not missing:
            return np.concatenate(found)
    raise ShapeError(f"the shape is (nearly) empty: {count - missing} of {count} points found inside")


def volume(solid: Solid, count: int, rng: np.random.Generator) -> tuple[float, float]:
    """Return the volume of a solid and its standard error [m^3], by `count` points in its bounding box."""
    lower, upper = solid.bounds
    share = float(solid.contains(lower + (upper - lower) * rng.random((count, 3))).mean())
    box = float(np.prod(upper - lower))
    return box * share, box * float(np.sqrt(share * (1.0 - share) / count))


def surface_points(solid: Solid, count: int, rng: np.random.Generator) -> FloatArray:
    """Return `count` points drawn uniformly from the surface of a solid, (count, 3) [m].

    Uniformly random lines cross every piece of a surface in proportion to its area (Cauchy-Crofton), so the crossings
    are the sample: no surface needs to be known, only where inside changes to outside.

    Raises
    ------
    ShapeError
        If hardly any line meets the shape.
    """
    lower, upper = solid.bounds
    center, radius = 0.5 * (lower + upper), 0.5 * float(np.linalg.norm(upper - lower))
    stations = np.linspace(-radius, radius, STEPS + 1)
    found: list[FloatArray] = []
    missing = count
    vain = 0
    while vain < BATCHES_MAX:
        feet, directions = _random_lines(min(max(missing, 64), LINES_MAX), radius, rng)
        feet = feet + center
        along = feet[:, None] + stations[:, None] * directions[:, None]
        inside = solid.contains(along.reshape(-1, 3)).reshape(along.shape[:2])
        line, step = np.nonzero(inside[:, 1:] != inside[:, :-1])
        outer = np.where(inside[line, step], stations[step + 1], stations[step])
        inner = np.where(inside[line, step], stations[step], stations[step + 1])
        points = _bisected(solid, feet[line], directions[line], inner, outer)[:missing]
        found.append(points)
        missing -= len(points)
        vain += not len(points)
        if not missing:
            return np.concatenate(found)
    raise ShapeError(f"the shape is (nearly) empty: {count - missing} of {count} points found on its surface")


def _random_lines(count: int, radius: float, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return feet and directions, (count, 3) each, of isotropic lines that meet the ball of `radius` at the origin."""
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    helper = np.where(np.abs(directions[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(directions, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(directions, first)
    distance, angle = radius * np.sqrt(rng.random((count, 1))), 2.0 * np.pi * rng.random((count, 1))
    return distance * (np.cos(angle) * first + np.sin(angle) * second), directions


def _bisected(
    solid: Solid, feet: FloatArray, directions: FloatArray, inner: FloatArray, outer: FloatArray
) -> FloatArray:
    """Return where each line crosses the surface between a station inside and one outside, (n, 3) [m]."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (inner + outer)
        inside = solid.contains(feet + middle[:, None] * directions)
        inner, outer = np.where(inside, middle, inner), np.where(inside, outer, middle)
    return feet + inner[:, None] * directions
