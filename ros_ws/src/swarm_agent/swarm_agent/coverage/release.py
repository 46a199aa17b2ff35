"""Release: robots that a covered shape can do without, found by all from the same records (decision 22).

A rule that chooses place after place ends with robots whose coverage later ones have taken over. Everybody who knows
where all stand finds the same ones that can go: without them no sample of the shape, and none of the frontier, is left
uncovered, and links still join the others. Which of them go is a minimum connected cover; it is looked for by going
through the robots in many orders and dropping each that can be spared.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import Key, Place, State
from swarm_agent.coverage.sense_sphere import TOUCHING, directions_of
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.sampling import interior_points, surface_points, volume
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

ORDERS = 40  # in which robots are gone through
DENSITY = 4000.0  # points per ball that stand for the volume of the shape, and half as many for its surface
POINTS_MIN, POINTS_MAX = 2000, 100_000
TRIALS = 20_000  # points by which the volume is told
ANYBODY = -1  # owner of a point that must stay covered whoever goes


class Release:
    """When one robot may leave its place.

    Parameters
    ----------
    mine : Key
        Its place.
    root : Key
        The leader's, which stays.
    solid : Solid
    config : CoverageConfig
    """

    def __init__(self, mine: Key, root: Key, solid: Solid, config: CoverageConfig) -> None:
        self._mine, self._root = mine, root
        self._solid, self._config = solid, config
        self._revision, self._since = -1, 0
        self._held: tuple[Place, ...] = ()
        self.is_decided = False

    def is_due(self, tick: int, board: Board) -> bool:
        """Return whether to leave: nothing is open, everybody can have heard the same, and this robot can be spared.

        `is_decided` tells afterward whether that has been looked at: a swarm is not done before.
        """
        if board.revision != self._revision:
            self._account(tick, board)
        if self.is_decided or board.count(State.OPEN) or board.count(State.TAKEN):
            return False
        # News takes a tick per link: up to the leader, and down again.
        hops = max(board.hops_from(self._root, over_taken=False).values(), default=0)
        protocol, news = self._config.protocol, min(2 * hops, len(board.held))
        if tick - self._since < news + protocol.heartbeat_ticks + protocol.quiet_ticks:
            return False
        self.is_decided = True
        return self._mine in needless(self._held, self._root, self._solid, self._config, board.link, board.barriers)

    def _account(self, tick: int, board: Board) -> None:
        """Begin to wait anew, unless the only news is who has left: they left by what this robot is about to find."""
        self._revision = board.revision
        held = tuple(board.places(State.HELD))
        known = {place.key: place for place in held}
        has_left = {place.key for place in board.places(State.NEEDLESS)}
        is_same = known.keys() <= {place.key for place in self._held} and all(
            place.key in has_left or known.get(place.key) == place for place in self._held
        )
        if not is_same or board.count(State.OPEN) or board.count(State.TAKEN):
            self._held, self._since, self.is_decided = held, tick, False


@lru_cache(maxsize=64)
def needless(  # noqa: PLR0913, PLR0917 - what a decision follows from
    places: tuple[Place, ...],
    root: Key,
    solid: Solid,
    config: CoverageConfig,
    link: float,
    barriers: Barriers = OPEN_SPACE,
) -> frozenset[Key]:
    """Return the places that can all be left at once; shared by all robots of one process that know the same.

    Parameters
    ----------
    places : tuple of Place
        All that are held, by key.
    root : Key
        The one that stays.
    solid : Solid
        Shape that is covered.
    config : CoverageConfig
        Range and samples of the spheres.
    link : float
        Places no farther apart are linked [m].
    barriers : Barriers, optional
        Obstacles that cut links.
    """
    keys = [place.key for place in places]
    if root not in keys:
        return frozenset()
    positions = np.array([place.position for place in places])
    links = _links(positions, link, barriers)
    if connected_components(links, directed=False, return_labels=False) > 1:
        return frozenset()  # some are cut off, or not heard of yet
    covers, owners = _cover(positions, solid, config)
    start = keys.index(root)
    stays = _must_stay(covers, owners)
    stays[start] = True
    covers, owners = _doubtful(covers, owners, stays)
    rng = rng_for(0, "coverage", "release")
    best: IntArray = np.empty(0, np.int64)
    spare = np.flatnonzero(~stays)
    for _ in range(ORDERS if len(spare) > 1 else len(spare)):
        gone = _spared(rng.permutation(spare), covers, owners, links)
        if len(gone) > len(best):
            best = gone
    return frozenset(keys[row] for row in best.tolist())


def _cover(positions: FloatArray, solid: Solid, config: CoverageConfig) -> tuple[BoolArray, IntArray]:
    """Return which robots cover which points, (m, n), and to whose frontier each point belongs, (m,).

    Points of the shape must stay covered, samples of a robot's sphere as long as it stays, by another one.
    """
    radius = config.range_m * (1.0 + TOUCHING)
    volume_points = _points(solid, config.range_m)
    samples = (positions[:, None] + config.range_m * directions_of(config)).reshape(-1, 3)
    owners = np.repeat(np.arange(len(positions)), len(samples) // len(positions))
    inside = solid.contains(samples)
    points = np.concatenate([volume_points, samples[inside]])
    owners = np.concatenate([np.full(len(volume_points), ANYBODY), owners[inside]])
    covers: BoolArray = cdist(points, positions) <= radius
    own = np.flatnonzero(owners != ANYBODY)
    covers[own, owners[own]] = False
    is_covered = covers.any(axis=1)  # what is open now stays so whoever goes
    return covers[is_covered], owners[is_covered]


def _must_stay(covers: BoolArray, owners: IntArray) -> BoolArray:
    """Return which robots alone cover a point that must stay covered, (n,)."""
    alone = covers[(covers.sum(axis=1) == 1) & (owners == ANYBODY)]
    stays: BoolArray = alone.any(axis=0)
    return stays


def _doubtful(covers: BoolArray, owners: IntArray, stays: BoolArray) -> tuple[BoolArray, IntArray]:
    """Return the points that no robot covers that stays anyway, each kind of them once."""
    is_doubtful = ~covers[:, stays].any(axis=1)
    kinds = np.unique(np.column_stack([owners[is_doubtful], covers[is_doubtful]]), axis=0)
    return kinds[:, 1:].astype(np.bool_), kinds[:, 0]


def _spared(order: IntArray, covers: BoolArray, owners: IntArray, links: csr_array) -> IntArray:
    """Return the robots of `order` that can go, looked at one after the other."""
    kept = np.ones(covers.shape[1], dtype=np.bool_)
    counts, counted = covers.sum(axis=1), np.ones(len(covers), dtype=np.bool_)
    for row in order.tolist():
        remains = counted & (owners != row)
        if (counts[remains & covers[:, row]] == 1).any():
            continue
        kept[row] = False
        rest = np.flatnonzero(kept)
        if connected_components(links[rest][:, rest], directed=False, return_labels=False) > 1:
            kept[row] = True
            continue
        counts, counted = counts - covers[:, row], remains
    return np.flatnonzero(~kept)


def _links(positions: FloatArray, link: float, barriers: Barriers) -> csr_array:
    pairs = barriers.pairs_in_sight(positions, link)
    ones = np.ones(len(pairs), dtype=np.int8)
    return csr_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(positions), len(positions)))


@lru_cache(maxsize=16)
def _points(solid: Solid, radius: float) -> FloatArray:
    """Return points in a shape and on its surface, (m, 3) [m]; all robots come to the same."""
    rng = rng_for(0, "coverage", "release points")
    balls = volume(solid, TRIALS, rng)[0] / (4.0 / 3.0 * float(np.pi) * radius**3)
    count = int(np.clip(DENSITY * balls, POINTS_MIN, POINTS_MAX))
    return np.concatenate([interior_points(solid, count, rng), surface_points(solid, count // 2, rng)])
