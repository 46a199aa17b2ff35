"""Layouts among obstacles: connected set cover on a visibility graph, greedily, a whole way at a time."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial.distance import cdist

from swarm_agent.coverage.config import CoverageConfig
from swarm_msgs_py.geometry.solids.barriers import Barriers
from swarm_msgs_py.geometry.solids.sampling import interior_points, surface_points
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray

INSIDE, BESIDE = 500, 300  # candidate places in the shape, and around it, where ways may lead
POINTS = 2000  # of the shape that are to be covered
RIM = 0.6  # of the longest link: how far beside shape and obstacles a candidate may be
FEW = 4.0  # points for which no robot is sent: they are no larger a share of the shape than gaps may be


def places_around(
    solid: Solid, leader: FloatArray, config: CoverageConfig, seed: int, barriers: Barriers
) -> FloatArray:
    """Return places that cover a shape among obstacles, each in sight of another one, (n, 3) [m], the leader first.

    Each round adds the candidate that newly covers most points per robot that it takes to link it, and the robots on
    the way there. What cannot be reached at all stays uncovered.

    Parameters
    ----------
    solid : Solid
    leader : (3,) array
        [m].
    config : CoverageConfig
    seed : int
    barriers : Barriers
    """
    reach = config.placement * config.range_m
    rng = rng_for(seed, "coverage", "detours")
    candidates = np.concatenate([leader[None], _candidates(solid, reach, barriers, rng)])
    points = np.concatenate([interior_points(solid, POINTS, rng), surface_points(solid, POINTS // 2, rng)])
    covers: BoolArray = cdist(candidates, points) <= config.range_m * (1.0 - config.layout.spare)
    links = _sight(candidates, reach, barriers)
    chosen, left = [0], ~covers[0]
    while left.any():
        hops, before, _ = dijkstra(
            links, directed=False, indices=chosen, unweighted=True, return_predecessors=True, min_only=True
        )
        gains = (covers @ left.astype(np.float64)) / np.maximum(hops, 1.0)
        best = int(np.argmax(gains))
        if not np.isfinite(hops[best]) or gains[best] * max(hops[best], 1.0) < FEW:
            break
        node = best
        while node not in chosen:
            chosen.append(node)
            left &= ~covers[node]
            node = int(before[node])
    return candidates[chosen]


def _candidates(solid: Solid, reach: float, barriers: Barriers, rng: np.random.Generator) -> FloatArray:
    """Return where robots might stand: in the shape, and beside it."""
    low, high = solid.bounds
    low, high = low - RIM * reach, high + RIM * reach
    beside = low + (high - low) * rng.random((BESIDE, 3))
    places = np.concatenate([interior_points(solid, INSIDE, rng), beside])
    free: FloatArray = places[~barriers.contain(places)]
    return free


def _sight(places: FloatArray, reach: float, barriers: Barriers) -> csr_array:
    """Return the graph of all pairs that see each other within `reach` [m]."""
    pairs = barriers.pairs_in_sight(places, reach)
    return csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(places), len(places)))
