"""The layout rule's plan: places that cover a shape with few robots, each linked to the tree of the others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from swarm_agent.coverage.chain_lattice import chain_lattice
from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.detours import places_around
from swarm_agent.coverage.expansion import Layout
from swarm_agent.coverage.layout_tree import rooted, with_relays
from swarm_agent.coverage.refinement import Task, fitted, greedy, without_a_hardly_needed
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.sampling import interior_points, surface_points, volume
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray

CHAIN_VOLUME = 1.97  # covered per robot of a chain lattice, in cubes of the range
BORNE_SIGMAS = 7.0  # of noise that links of a lattice bear while the swarm unfolds: there are a thousand of them
PATIENCE = 4  # times the kicks of a number of robots for the start, which must not fail
CANDIDATES = 500  # places that the greedy start chooses from
REMOVALS = 5  # robots whose removal is tried before a number of robots is given up
DENSITY = 80.0  # points of the cloud per robot of a lattice: fewer leave gaps between them
DEEP = 6.0  # first, few robots on a tree that may be deep; the same number is then tried on flatter ones
FLATTER = (4.0, 3.0)
LINK_SLACK = 0.995  # of the longest link, for the search: descent leaves links a little too long


def plan_layout(
    solid: Solid, leader: FloatArray, config: CoverageConfig, seed: int = 0, barriers: Barriers = OPEN_SPACE
) -> Layout:
    """Return places that cover a shape, for a leader who cannot choose its own.

    Parameters
    ----------
    solid : Solid
    leader : (3,) array
        Where the leader stands [m].
    config : CoverageConfig
        Links are at most `placement` times the range long.
    seed : int
        Of the random points by which places are found and judged; equal seeds give equal layouts.
    barriers : Barriers, optional
        Obstacles that places and links keep clear of. The search knows nothing of them: where they are in the way of
        what it finds, places come from a coarser one that goes around them (`detours`).
    """
    found = _unobstructed(solid, leader, config, seed)
    if not barriers:
        return found
    reach = config.placement * config.range_m
    if not barriers.contain(found.positions).any():
        clear = rooted(found.positions, reach, barriers)
        if clear is not None:
            return clear
    around = rooted(places_around(solid, leader, config, seed, barriers), reach, barriers)
    if around is None:
        raise AssertionError("ways around obstacles are linked")
    return around


def _unobstructed(solid: Solid, leader: FloatArray, config: CoverageConfig, seed: int) -> Layout:
    size, _ = volume(solid, config.layout.judged_points, rng_for(seed, "coverage", "volume"))
    expected = size / (CHAIN_VOLUME * config.range_m**3)
    if expected > config.layout.refined_max:
        return _lattice_layout(solid, leader, config, seed, expected)
    return _refined_layout(solid, leader, config, seed) or _lattice_layout(solid, leader, config, seed, expected)


def _lattice_layout(solid: Solid, leader: FloatArray, config: CoverageConfig, seed: int, expected: float) -> Layout:
    reach = min(config.placement * config.range_m, config.range_m - BORNE_SIGMAS * config.motion.sigma_m)
    cloud = _cloud(solid, int(DENSITY * expected), int(0.5 * DENSITY * expected), seed)
    sites = chain_lattice(cloud, leader, config.range_m * (1.0 - config.layout.spare), reach)
    return _linked(sites, reach)


def _refined_layout(solid: Solid, leader: FloatArray, config: CoverageConfig, seed: int) -> Layout | None:
    """Return the layout of fewest robots that descent finds: one robot less each time, until a gap remains.

    None if it does not even find one of as many robots as the greedy start has.
    """
    settings, reach = config.layout, config.placement * config.range_m
    task = Task(
        cloud=_cloud(solid, settings.interior_points, settings.surface_points, seed),
        leader=leader,
        solid=solid,
        judges=settings.judged_points,
        radius=config.range_m * (1.0 - settings.spare),
        reach=LINK_SLACK * reach,
        radius_max=config.range_m,
        link_max=reach,
        missed_max=1.0 - settings.covered_fraction,
        power=DEEP,
    )
    rng = rng_for(seed, "coverage", "search")
    start = greedy(task, task.cloud[: min(settings.interior_points, CANDIDATES)], len(task.cloud))
    best, task = fitted(task, start, settings.kick_share, PATIENCE * settings.kicks, rng)
    if best is None:
        return None
    while len(best) > 1:
        for rank in range(min(REMOVALS, len(best) - 1)):
            fewer = without_a_hardly_needed(task, best, rank)
            found, task = fitted(task, fewer, settings.kick_share, settings.kicks, rng)
            if found is not None:
                break
        if found is None:
            break
        best = found
    for power in FLATTER:
        found, task = fitted(replace(task, power=power), best, settings.kick_share, settings.kicks // 2, rng)
        best = best if found is None else found
    return _linked(best, reach)


def _linked(places: FloatArray, reach: float) -> Layout:
    """Return the tree over some places, with relays where it needs them."""
    layout = rooted(places, reach)
    if layout is None:
        layout = rooted(with_relays(places, reach), reach)
    if layout is None:
        raise AssertionError("relays stand closer than a link")
    return layout


def _cloud(solid: Solid, inner: int, outer: int, seed: int) -> FloatArray:
    """Return points inside the shape, then points on its surface, (inner + outer, 3) [m]."""
    inside = interior_points(solid, inner, rng_for(seed, "coverage", "interior"))
    return np.concatenate([inside, surface_points(solid, outer, rng_for(seed, "coverage", "surface"))])
