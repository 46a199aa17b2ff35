"""Which frontier point becomes the next target [I8]; none of the rules depends on the last bits of a number."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial.distance import cdist

from swarm_agent.coverage.config import CoverageConfig, Rule
from swarm_agent.coverage.sense_sphere import TOUCHING, directions_of, fibonacci_directions
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import FloatArray

REACH = 3.0  # in ranges: whose frontier, or coverage, a newcomer next to a robot may touch
SHARES = (1.0, 0.85, 0.7)  # of the farthest place toward a frontier point: nearer ones leave no slivers behind
VOLUME_WEIGHT = 5.0  # of the volume newly covered, in balls, against frontier points deleted, in spheres
OPENED_WEIGHT = 3.0  # the same of frontier points that the newcomer would have
LATTICE = 0.2  # of the range, between the points that stand for volume
SPHERE = 400  # samples that stand for the newcomer's sphere


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """What a robot knows of its surroundings when it chooses; everything relative to it [m].

    Attributes
    ----------
    own : (k, 3) array
        Its frontier points, k >= 1.
    around : (m, 3) array
        Frontier points of all robots within 3 r_sc, itself included.
    others : (j, 3) array
        Robots within 3 r_sc, itself included, and places that are reserved for robots.
    position : (3,) array
        Where it is, in the frame of the shape.
    solid : Solid
    """

    own: FloatArray
    around: FloatArray
    others: FloatArray
    position: FloatArray
    solid: Solid


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """A place for the next robot.

    Attributes
    ----------
    row : int
        Of the frontier point that it is for.
    place : (3,) array
        Relative to the robot that chooses [m].
    score : float
        How good it is, in spheres of frontier points; 0 where the rule does not ask.
    """

    row: int
    place: FloatArray
    score: float = 0.0


def choose(config: CoverageConfig, site: Site, rng: np.random.Generator) -> Choice:
    """Return where the next robot is to go, next to the robot of `site`.

    What `Rule.LAYOUT` wants stands in the layout, so that it counts as `Rule.GAIN` here.

    Parameters
    ----------
    config : CoverageConfig
        Range, placement and rule.
    site : Site
    rng : Generator
        Decides ties.
    """
    if config.rule in {Rule.FIRST, Rule.RANDOM}:
        row = 0 if config.rule is Rule.FIRST else int(rng.integers(len(site.own)))
        return Choice(row, config.placement * site.own[row])
    radius = config.range_m
    places = np.concatenate([share * config.placement * site.own for share in SHARES])
    samples = len(directions_of(config))
    scores = VOLUME_WEIGHT * _volumes(places, site, radius) + _covered(places, site.around, radius) / samples
    scores -= OPENED_WEIGHT * _opened(places, site, radius)
    chosen = int(rng.choice(np.flatnonzero(scores >= scores.max() - TOUCHING)))
    return Choice(chosen % len(site.own), places[chosen], float(scores.max()))


def _covered(places: FloatArray, points: FloatArray, radius: float) -> FloatArray:
    """Return how many of `points` (m, 3) [m] a robot at each of `places` (k, 3) [m] would cover, (k,)."""
    counts = np.count_nonzero(cdist(places, points) <= radius * (1.0 + TOUCHING), axis=1)
    numbers: FloatArray = counts.astype(np.float64)
    return numbers


def _volumes(places: FloatArray, site: Site, radius: float) -> FloatArray:
    """Return how much volume of the shape each place would newly cover, in balls, (k,)."""
    points = radius * _lattice()
    points = points[cdist(points, site.others).min(axis=1) > radius]
    points = points[site.solid.contains(site.position + points)]
    ball = 4.0 / 3.0 * float(np.pi) / LATTICE**3
    shares: FloatArray = _covered(places, points, radius) / ball
    return shares


def _opened(places: FloatArray, site: Site, radius: float) -> FloatArray:
    """Return how much frontier a robot at each place would have, in spheres, (k,)."""
    sphere = radius * fibonacci_directions(SPHERE)
    points = (places[:, None] + sphere).reshape(-1, 3)
    is_open = site.solid.contains(site.position + points)
    is_open[is_open] = cdist(points[is_open], site.others).min(axis=1) > radius * (1.0 + TOUCHING)
    shares: FloatArray = is_open.reshape(len(places), SPHERE).mean(axis=1)
    return shares


@lru_cache(maxsize=1)
def _lattice() -> FloatArray:
    """Return the points within two ranges of the origin, where a neighbor may cover, (n, 3), in ranges."""
    steps = np.arange(-2.0, 2.0 + LATTICE, LATTICE) + 0.5 * LATTICE
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    points: FloatArray = grid[np.einsum("ij,ij->i", grid, grid) <= 4.0]
    points.flags.writeable = False
    return points
