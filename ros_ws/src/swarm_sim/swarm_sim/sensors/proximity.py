"""Short-range relative sensing: nearest surface points of robots and walls, in the body frame."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, IntArray
from swarm_sim.config import ProximityConfig
from swarm_sim.world.obstacles import ObstacleField
from swarm_sim.world.world import BodyState

STANDOFF = 1e-6
"""Share of the sight line that is left out at the target, so that a wall does not hide itself."""


class Proximity:
    """The proximity sensors of all robots.

    Every other robot's coverage circle gives its nearest point, also when that robot's electronics are dead; every
    wall face gives its nearest point. A wall hides what is behind it.

    Parameters
    ----------
    config : ProximityConfig
    radii : (n,) array
        Coverage radii of the robots [m].
    obstacles : ObstacleField
    seed : int
        Seed of the run.
    """

    def __init__(self, config: ProximityConfig, radii: FloatArray, obstacles: ObstacleField, seed: int) -> None:
        self._config = config
        self._radii = radii
        self._obstacles = obstacles
        self._seed = seed

    def measure(self, tick: int, bodies: BodyState) -> list[FloatArray]:
        """Return the points (k, 2) that each robot sees, nearest first, k <= `points_max` [m]."""
        centers, n = bodies.positions, len(self._radii)
        reach, cap = self._config.range_m, self._config.points_max
        noise = rng_for(self._seed, "proximity", tick).normal(size=(n, cap, 2)) * self._config.sigma_m

        robots, targets = self._robot_points(centers)
        observers, surface = self._obstacles.facing_points(centers, reach)
        observers, surface = np.concatenate([robots, observers]), np.concatenate([targets, surface])
        sight = surface - centers[observers]
        is_hidden = self._obstacles.is_blocked(centers[observers], surface - STANDOFF * sight)
        observers, sight = observers[~is_hidden], sight[~is_hidden]

        # Nearest first; ties by content, so that the order does not depend on how the points were found.
        east, north = sight.T
        order = np.lexsort((north, east, east * east + north * north, observers))
        observers, sight = observers[order], sight[order]
        cuts = np.searchsorted(observers, np.arange(n + 1))
        rank = np.arange(len(observers)) - cuts[observers]
        kept = rank < cap
        observers, sight, rank = observers[kept], sight[kept], rank[kept]
        cos, sin = np.cos(bodies.yaws)[observers], np.sin(bodies.yaws)[observers]
        east, north = sight.T
        points = np.stack([cos * east + sin * north, cos * north - sin * east], axis=1) + noise[observers, rank]
        points.flags.writeable = False
        ends = np.searchsorted(observers, np.arange(n + 1)).tolist()
        return [points[a:b] for a, b in pairwise(ends)]

    def _robot_points(self, centers: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the observers (k,) and nearest circle points (k, 2) of all pairs of robots within reach."""
        x, y = centers.T
        distances = np.hypot(x - x[:, None], y - y[:, None])
        surface = np.maximum(distances - self._radii, 0.0)
        np.fill_diagonal(surface, np.inf)
        observers, seen = np.nonzero(surface <= self._config.range_m)
        share = surface[observers, seen] / np.maximum(distances[observers, seen], np.finfo(np.float64).tiny)
        return observers, centers[observers] + share[:, None] * (centers[seen] - centers[observers])
