"""Expansion without messages: where Algorithm 1 puts robots, for planning and as a yardstick.

References
----------
.. [1] M. Minoux, "Accelerated greedy algorithms for maximizing submodular set functions", Optimization Techniques,
       Springer 1978.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from swarm_agent.coverage.config import CoverageConfig, Rule
from swarm_agent.coverage.rules import choose
from swarm_agent.coverage.sense_sphere import directions_of
from swarm_agent.coverage.sites import REACH, Choice, Site
from swarm_agent.coverage.store import FrontierStore
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import FloatArray, IntArray

ROOT = -1  # parent of the leader


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """Places of robots and the tree that links them.

    Attributes
    ----------
    positions : (n, 3) array
        [m]; the leader comes first, and everybody after the own parent.
    parents : (n,) int array
        Row of the robot next to which each was placed; `ROOT` for the leader.
    """

    positions: FloatArray
    parents: IntArray

    @property
    def edge_lengths(self) -> FloatArray:
        """Length of the link of each follower to its parent, (n - 1,) [m]."""
        steps = self.positions[1:] - self.positions[self.parents[1:]]
        lengths: FloatArray = np.linalg.norm(steps, axis=1)
        return lengths


def expand(  # noqa: PLR0913, PLR0917 - what an expansion follows from
    solid: Solid,
    leader: FloatArray,
    config: CoverageConfig,
    robots_max: int,
    rng: np.random.Generator,
    barriers: Barriers = OPEN_SPACE,
) -> Layout:
    """Return where exact placement by the rule of `config` puts robots (Algorithm 1).

    Parameters
    ----------
    solid : Solid
        Shape to cover.
    leader : (3,) array
        Where the leader stands [m].
    config : CoverageConfig
    robots_max : int
        Stop at this many, the leader included.
    rng : Generator
        For the rule, and which of the robots of least hops is first.
    barriers : Barriers, optional
        Obstacles that places and links keep clear of.
    """
    store = FrontierStore(directions_of(config), config.range_m, solid)
    store.enable(leader)
    parents, hops = [ROOT], [0]
    scores = dict[int, float]()
    while len(store) < robots_max:
        owners = np.flatnonzero(store.is_open.any(axis=1))
        if not len(owners):
            break
        distances = np.array(hops)[owners]
        nearest = owners[distances == distances.min()]
        if config.rule is not Rule.GAIN:
            nearest = rng.choice(nearest, 1)
        found = _best(
            store, nearest.tolist(), scores, lambda owner: _chosen(store, owner, solid, config, rng, barriers)
        )
        if found is None:
            continue
        owner, offset = found
        store.enable(store.positions[owner] + offset)
        parents.append(owner)
        hops.append(hops[owner] + 1)
    return Layout(store.positions.copy(), np.array(parents))


def _best(
    store: FrontierStore, owners: list[int], scores: dict[int, float], chosen: Callable[[int], Choice | None]
) -> tuple[int, FloatArray] | None:
    """Return which of `owners` has the best place for the next robot, and that place relative to it [m].

    What a place newly covers only shrinks as others are taken, so that an owner's `scores` of before stand for bounds:
    only the best of these is judged again, until it stays the best (accelerated greedy [1]_). They are no true bounds,
    since the frontier that counts against a place shrinks as well, and places are searched by lot.
    """
    judged = dict[int, FloatArray]()
    while owners:
        owner = max(owners, key=lambda each: (scores.get(each, np.inf), -each))
        if owner in judged:
            return owner, judged[owner]
        choice = chosen(owner)
        if choice is None:  # whatever is left of its frontier is behind an obstacle
            store.give_up(owner)
            owners.remove(owner)
        else:
            scores[owner], judged[owner] = choice.score, choice.place
    return None


def _chosen(  # noqa: PLR0913, PLR0917 - what a choice follows from
    store: FrontierStore,
    owner: int,
    solid: Solid,
    config: CoverageConfig,
    rng: np.random.Generator,
    barriers: Barriers,
) -> Choice | None:
    """Return where a robot would have the next one, None if it sees no place for it."""
    place = store.positions[owner].copy()
    own = store.points_of(np.array([owner])) - place
    own = own[~barriers.cut(np.broadcast_to(place, own.shape), place + config.placement * own)]
    if not len(own):
        return None
    near = store.near(place, REACH * config.range_m)
    around, others = store.points_of(near) - place, store.positions[near] - place
    return choose(config, Site(own, around, others, place, solid), rng)
