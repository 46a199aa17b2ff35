"""The gain rule: the place next to a robot that covers most, leaves no slivers, and leaves the least to be done.

Everything is judged by what one robot knows of its surroundings. Some places toward its frontier points, far apart
from each other, are improved by what they gain (`_Worth`); for each, the rest of the surroundings is then filled
greedily, as if all robots around chose at once, and the place with which that takes fewest robots wins. Such a
look ahead with a greedy base policy is a rollout. What a place covers bounds its worth: places whose bound is no
better than what is known already are left out (branch and bound), which changes no choice.

References
----------
.. [1] D. P. Bertsekas, "Rollout algorithms for discrete optimization: a survey", Handbook of Combinatorial
       Optimization, Springer 2013.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.sense_sphere import TOUCHING, covered_samples, directions_of
from swarm_agent.coverage.sites import REACH, Choice, Site
from swarm_msgs_py.geometry.solids.sampling import interior_points, volume
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray

SHARES = (1.0, 0.85, 0.7)  # of the farthest place toward a frontier point: nearer ones leave no slivers behind
COARSE_MAX = 300  # places that are looked at first
STARTS, APART = 6, 0.3  # best of them that are improved, and how far they are apart, in ranges
TRIES, ROUNDS = 12, 3  # places around each of them that are tried, and how often
TRY_SHARE = 0.12  # of the range: standard deviation of the first tries; each round halves it
VOLUME_WEIGHT = 4.0  # of the volume newly covered, in balls, against frontier points deleted, in spheres
OPENED_WEIGHT = 4.0  # the same of frontier points that the newcomer would have
FURTHER_WEIGHT = 1.0  # the same of each robot that it takes afterward
FURTHER_PLACES = 300  # of the surroundings, where those may stand
MISPLACED = 0.5  # of the tolerance of arrival: how far off its place a robot is taken to stop
BATCH = 40  # places whose frontier is told at once
FIRST = 6  # nearest robots that a newcomer's samples are compared with before all others
DENSITY = 400.0  # points per ball that stand for the volume of the shape
POINTS_MIN, POINTS_MAX = 200, 400_000  # of the whole shape
TRIALS = 20_000  # points by which its volume is told


def best_place(config: CoverageConfig, site: Site, rng: np.random.Generator) -> Choice:
    """Return where the gain rule wants the next robot.

    Parameters
    ----------
    config : CoverageConfig
    site : Site
    rng : Generator
        Of the places that are tried.
    """
    worth = _Worth(config, site)
    places, values = _improved(*_starts(config, site, worth, rng), config, site, worth, rng)
    scores = values - FURTHER_WEIGHT * _further(places, config, site, rng)
    best = int(np.argmax(scores))
    row = int(np.argmin(np.linalg.norm(site.own - places[best], axis=1)))
    return Choice(row, places[best], float(values[best]))


def _sure_range(config: CoverageConfig) -> float:
    """Return how far from its place a robot is counted on to cover [m], though it stops a little off.

    A choice that counts on the whole range leaves slivers where the robot stops, each of which takes one of its own.
    """
    motion = config.motion
    return config.range_m - MISPLACED * motion.arrival_sigmas * motion.sigma_m


class _Worth:
    """How good places for the next robot are: what it newly covers, less the frontier that it would bring along.

    A place that takes most at once leaves slivers at the edges of the shape, each of which takes a robot of its own.
    They show as frontier of the newcomer, beside and behind it, so that this counts against it.

    Parameters
    ----------
    config : CoverageConfig
    site : Site
    """

    def __init__(self, config: CoverageConfig, site: Site) -> None:
        self._site, self._radius, self._directions = site, _sure_range(config), directions_of(config)
        self._others = site.others[np.argsort(np.linalg.norm(site.others, axis=1), kind="stable")]
        near = _volume_near(site, self._radius, 2.0)
        left = near[_beyond(near, site.others, config.range_m)]
        self._points = np.concatenate([left, site.around])
        shares = VOLUME_WEIGHT / DENSITY, 1.0 / len(self._directions)
        self._weights = np.repeat(shares, (len(left), len(site.around)))

    def bounds(self, places: FloatArray) -> FloatArray:
        """Return what `places` (k, 3) [m] newly cover, (k,), in spheres of frontier points; the worth is no more."""
        covers = _within(places, self._points, self._radius * (1.0 + TOUCHING))
        covered: FloatArray = covers @ self._weights
        return covered

    def cost(self, places: FloatArray) -> FloatArray:
        """Return what the frontier that robots at `places` (k, 3) [m] would have takes from their bounds, (k,)."""
        count = len(self._directions)
        # Most samples are in the coverage of the nearest few; only the rest is compared with everybody.
        is_open = np.ones((count, len(places)), dtype=np.bool_)
        for other in self._others[:FIRST]:
            is_open &= ~covered_samples(self._directions, self._radius, other - places)
        left = np.flatnonzero(is_open)
        axes = zip((self._radius * self._directions).T, (self._site.position + places).T, strict=True)
        points = np.stack([np.add.outer(spokes, middles).take(left) for spokes, middles in axes], axis=1)
        others = self._site.position + self._others[FIRST:]
        bare = np.flatnonzero(_beyond(points, others, self._radius * (1.0 + TOUCHING)))
        left, points = left[bare], points.take(bare, axis=0)
        left = left[self._site.solid.contains(points)]
        opened: FloatArray = np.bincount(left % len(places), minlength=len(places)) / count
        return OPENED_WEIGHT * opened


def _starts(
    config: CoverageConfig, site: Site, worth: _Worth, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return the best places toward frontier points that are some way apart, (k, 3) [m], and their worth, (k,)."""
    places = np.concatenate([share * config.placement * site.own for share in SHARES])
    if len(places) > COARSE_MAX:
        places = places[rng.choice(len(places), COARSE_MAX, replace=False)]
    # Values are bounds until the frontier is told of, which only those that look best are asked for.
    values, is_exact = worth.bounds(places), np.zeros(len(places), dtype=np.bool_)
    chosen, left = list[int](), np.ones(len(places), dtype=np.bool_)
    while len(chosen) < STARTS and left.any():
        best = int(np.where(left, values, -np.inf).argmax())
        if is_exact[best]:
            chosen.append(best)
            left &= np.linalg.norm(places - places[best], axis=1) > APART * config.range_m
        else:
            rows = np.flatnonzero(left & ~is_exact)
            rows = rows[np.argsort(-values[rows], kind="stable")[:BATCH]]
            values[rows] -= worth.cost(places[rows])
            is_exact[rows] = True
    return places[chosen], values[chosen]


def _improved(  # noqa: PLR0913, PLR0917 - what a search follows from
    places: FloatArray,
    values: FloatArray,
    config: CoverageConfig,
    site: Site,
    worth: _Worth,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Return the best place near each of `places` (k, 3) [m], and its worth.

    Frontier points are so far apart that the best place, such as one on the axis of a beam, is between them.
    """
    spread, each = TRY_SHARE * config.range_m, np.arange(len(places))
    for _ in range(ROUNDS):
        tries = places[:, None] + spread * rng.normal(size=(len(places), TRIES, 3))
        lengths = np.linalg.norm(tries, axis=2, keepdims=True)
        tries *= np.minimum(1.0, config.placement * config.range_m / lengths)
        flat = tries.reshape(-1, 3)
        found = np.where(_beyond(flat, site.own, config.range_m), -np.inf, worth.bounds(flat))
        hopeful = np.flatnonzero(found > np.repeat(values, TRIES))
        found[hopeful] -= worth.cost(flat[hopeful])
        found = found.reshape(len(places), TRIES)
        tries, found = (
            np.concatenate([places[:, None], tries], axis=1),
            np.concatenate([values[:, None], found], axis=1),
        )
        best = found.argmax(axis=1)
        places, values = tries[each, best], found[each, best]
        spread *= 0.5
    return places, values


def _further(places: FloatArray, config: CoverageConfig, site: Site, rng: np.random.Generator) -> FloatArray:
    """Return how many more robots a greedy filling of the surroundings takes after one at each place, (k,)."""
    reach = config.placement * config.range_m
    near = _volume_near(site, config.range_m, REACH)
    if not len(near):  # a shape too thin for points: nothing tells the places apart
        return np.zeros(len(places))
    spots = near[rng.choice(len(near), min(FURTHER_PLACES, len(near)), replace=False)]
    wanted = np.concatenate([near[_beyond(near, site.others, config.range_m)], site.around])
    covers = _within(wanted, spots, _sure_range(config))
    counted = covers.astype(np.float32)
    linked = _within(spots, spots, reach)
    left = ~_within(wanted, places, _sure_range(config))
    can = ~_beyond(spots, site.others, reach)[:, None] | _within(spots, places, reach)
    gained = counted.T @ left.astype(np.float32)  # counts, so that float32 is exact and they can be kept up to date
    further, busy = np.zeros(len(places)), np.arange(len(places))
    while len(busy):
        possible = np.where(can[:, busy], gained[:, busy], 0.0)
        best = possible.argmax(axis=0)
        goes_on = possible[best, np.arange(len(busy))] > 0.0
        busy, best = busy[goes_on], best[goes_on]
        further[busy] += 1.0
        newly = left[:, busy] & covers[:, best]
        rows = np.flatnonzero(newly.any(axis=1))
        gained[:, busy] -= counted[rows].T @ newly[rows].astype(np.float32)
        left[:, busy] &= ~newly
        can[:, busy] |= linked[best].T
    return further


def _within(points: FloatArray, others: FloatArray, reach: float) -> BoolArray:
    """Return which of `points` (n, 3) [m] are within `reach` [m] of which of `others` (m, 3) [m], (n, m)."""
    # |p - o|^2 <= reach^2 with the squares multiplied out: one product instead of n m distances.
    halves = -0.5 * np.einsum("ij,ij->i", others, others)
    products = np.column_stack([points, np.ones(len(points))]) @ np.column_stack([others, halves]).T
    within: BoolArray = products >= 0.5 * (np.einsum("ij,ij->i", points, points) - reach * reach)[:, None]
    return within


def _beyond(points: FloatArray, others: FloatArray, reach: float) -> BoolArray:
    """Return which of `points` (n, 3) [m] are within `reach` [m] of none of `others` (m, 3) [m], (n,)."""
    near: BoolArray = np.any(_within(others, points, reach), axis=0)  # along the axis that NumPy reduces fastest
    return ~near


def _volume_near(site: Site, radius: float, reach: float) -> FloatArray:
    """Return the points that stand for the volume within some ranges of the robot, relative to it, (n, 3) [m]."""
    points, tree = _volume_points(site.solid, radius)
    near: FloatArray = points[np.sort(tree.query_ball_point(site.position, reach * radius))] - site.position
    return near


@lru_cache(maxsize=16)
def _volume_points(solid: Solid, radius: float) -> tuple[FloatArray, cKDTree]:
    """Return points that stand for the volume of a shape, (n, 3) [m]; all robots come to the same."""
    rng = rng_for(0, "coverage", "volume points")
    balls = volume(solid, TRIALS, rng)[0] / (4.0 / 3.0 * float(np.pi) * radius**3)
    points = interior_points(solid, int(np.clip(DENSITY * balls, POINTS_MIN, POINTS_MAX)), rng)
    points.flags.writeable = False
    return points, cKDTree(points)
