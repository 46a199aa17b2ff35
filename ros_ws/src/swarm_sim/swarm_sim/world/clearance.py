"""Free gaps between coverage circles, and between circles and obstacles, over the samples of a tick."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from swarm_msgs_py.types import FloatArray, IntArray
from swarm_sim.world.obstacles import ObstacleField


@dataclass(frozen=True, slots=True)
class Clearance:
    """Outcome of a tick.

    Attributes
    ----------
    min_gap : float
        Smallest free gap [m]; negative where something overlaps, infinite for one robot without obstacles.
    robot_overlaps : tuple of (int, int)
        Rows (i, j), i < j, of robots whose circles overlapped at some sample.
    obstacle_overlaps : tuple of (int, int)
        Row of the robot and number of the obstacle that its circle entered.
    """

    min_gap: float
    robot_overlaps: tuple[tuple[int, int], ...]
    obstacle_overlaps: tuple[tuple[int, int], ...]


def clearance(start: FloatArray, samples: FloatArray, radii: FloatArray, obstacles: ObstacleField) -> Clearance:
    """Return the smallest gap and all overlaps, at the start and at every sample.

    Only pairs that the motion of this tick could have brought below the smallest gap at the start are looked at sample
    by sample: a gap shrinks by at most what its two bodies moved.

    Parameters
    ----------
    start : (n, 2) array
        Positions before the tick [m].
    samples : (m, n, 2) array
        Positions during the tick [m].
    radii : (n,) array
        Coverage radii [m].
    obstacles : ObstacleField
    """
    moved = np.sqrt(_squares(samples - start).max(axis=0))
    instants = np.concatenate([start[None], samples])
    first, second = _pairs(len(radii))
    gaps = np.sqrt(_squares(start[first] - start[second])) - radii[first] - radii[second]
    best = float(gaps.min()) if gaps.size else np.inf

    close = np.flatnonzero(gaps - moved[first] - moved[second] <= max(best, 0.0))
    i, j = first[close], second[close]
    apart = np.sqrt(_squares(instants[:, i] - instants[:, j])) - radii[i] - radii[j]
    worst = apart.min(axis=0)
    best = min(best, float(worst.min())) if worst.size else best
    touching = tuple((int(a), int(b)) for a, b in zip(i[worst < 0.0], j[worst < 0.0], strict=True))
    best, entered = _obstacle_clearance(instants, radii + moved, radii, obstacles, best)
    return Clearance(best, touching, entered)


@lru_cache(maxsize=1)
def _pairs(count: int) -> tuple[IntArray, IntArray]:
    """Return the rows of all pairs of robots; their number does not change in a run."""
    first, second = np.triu_indices(count, k=1)
    first.flags.writeable = second.flags.writeable = False
    return first, second


def _squares(vectors: FloatArray) -> FloatArray:
    """Return the squared lengths of vectors (..., 2)."""
    x, y = vectors[..., 0], vectors[..., 1]
    squares: FloatArray = x * x + y * y
    return squares


def _obstacle_clearance(
    instants: FloatArray, reaches: FloatArray, radii: FloatArray, obstacles: ObstacleField, best: float
) -> tuple[float, tuple[tuple[int, int], ...]]:
    """Return the smallest gap so far including obstacles, and the obstacle overlaps."""
    entered = []
    # The box distance never exceeds the true one, so nearest boxes first and stop early is exact.
    least = obstacles.box_distances(instants[0]) - reaches[:, None]
    for flat in np.argsort(least, axis=None, kind="stable"):
        robot, obstacle = divmod(int(flat), obstacles.count)
        if least[robot, obstacle] > max(best, 0.0):
            break
        gap = float((obstacles.signed_distances(instants[:, robot], obstacle) - radii[robot]).min())
        best = min(best, gap)
        if gap < 0.0:
            entered.append((robot, obstacle))
    return best, tuple(sorted(entered))
