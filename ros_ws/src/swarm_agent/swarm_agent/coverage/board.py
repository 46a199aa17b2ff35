"""What a robot knows of all places: records that only grow in rank, so that any order of frames leads to one board."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from swarm_agent.coverage.frames import NOBODY, Key, Place, State, fingerprint
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.types import FloatArray, IntArray, NodeId

Search = tuple[FloatArray, IntArray, list[Key]]
SHORTEST = 1e-6  # length of a link between two places at one point [m]: a sparse matrix would forget 0
DETOUR = 1e6  # what a link that may not hold costs, in links or meters: more than any way round it


class Board:
    """All places that a robot has heard of.

    Merging is commutative, associative and idempotent: frames may be lost, repeated or late, and two boards that have
    seen the same records are equal. Nobody's word is needed but that of the robot concerned, or of one that has missed
    it.

    Parameters
    ----------
    link : float
        Two places no farther apart are linked once both are held, wherever within the tolerance robots stop [m].
    spare : float, optional
        Two places that are farther apart, by no more than this, are linked if robots stop well [m]. Who replaces one
        that died stops a little off its place, so that one further out may have no better link: ways lead over such
        links where there is no other way.
    barriers : Barriers, optional
        Obstacles that cut links.

    Attributes
    ----------
    link : float
    barriers : Barriers
    digest : int
        Fingerprint of all records, 32 bits.
    revision : int
        Counts the news.
    touched : list of NodeId
        Whose places have changed, `NOBODY` included, in the order of the news: so that those who keep account need not
        go through all places again.
    """

    def __init__(self, link: float, spare: float = 0.0, barriers: Barriers = OPEN_SPACE) -> None:
        self.link, self._spare = link, spare
        self.barriers = barriers
        self._places: dict[Key, Place] = {}
        self._in_state: dict[State, dict[Key, Place]] = {state: {} for state in State}
        self._held: dict[NodeId, Place] = {}
        self._bound: dict[NodeId, Place] = {}
        self.touched: list[NodeId] = []
        self.digest = 0
        self.revision = 0
        self._searches: dict[tuple[Key, bool, bool], Search] = {}
        self._held_positions: FloatArray | None = None

    def __len__(self) -> int:
        return len(self._places)

    def merge(self, place: Place) -> bool:
        """Take a record in; return whether it was news."""
        known = self._places.get(place.key)
        if known is place:  # most of what is heard has been heard before
            return False
        if known is not None:
            if place.rank <= known.rank:
                return False
            self.digest ^= fingerprint(known)
            del self._in_state[known.state][place.key]
            for holders in (self._held, self._bound):
                if holders.get(known.holder) is known:
                    del holders[known.holder]
            self.touched.append(known.holder)
        self.digest ^= fingerprint(place)
        self._places[place.key] = self._in_state[place.state][place.key] = place
        if place.state is State.HELD:
            self._held[place.holder] = place
        elif place.state is State.TAKEN:
            self._bound[place.holder] = place
        self.touched.append(place.holder)
        self.revision += 1
        self._searches.clear()
        self._held_positions = None
        return True

    def get(self, key: Key) -> Place | None:
        """Return the record of a place, None if there is none."""
        return self._places.get(key)

    def places(self, *states: State) -> list[Place]:
        """Return the places in any of `states`, by key."""
        return [place for _, place in sorted(pair for state in states for pair in self._in_state[state].items())]

    def count(self, state: State) -> int:
        """Return how many places are in `state`."""
        return len(self._in_state[state])

    @property
    def held(self) -> Mapping[NodeId, Place]:
        """Who holds which place."""
        return self._held

    @property
    def bound(self) -> Mapping[NodeId, Place]:
        """Who is under way to which place."""
        return self._bound

    @property
    def held_positions(self) -> FloatArray:
        """Where the robots are that hold places, (n, 3) [m]."""
        if self._held_positions is None:
            self._held_positions = _positions(self._held.values())
        return self._held_positions

    def everything(self) -> list[Place]:
        """Return all records, by key."""
        return [self._places[key] for key in sorted(self._places)]

    def freed(self, place: Place, state: State) -> Place:
        """Return the record that says that nobody has `place` any more; `state` is OPEN or WITHDRAWN."""
        return Place(place.key, place.version + 1, state, NOBODY, place.position)

    def hops_from(self, root: Key, *, over_taken: bool) -> dict[Key, int]:
        """Return how many links each place is from `root`, over places that are held (or taken); see `path`.

        One that may not hold counts as `DETOUR` links.
        """
        hops, _, keys = self._searched(root, over_taken=over_taken, by_length=False)
        return {key: int(count) for key, count in zip(keys, hops.tolist(), strict=True) if np.isfinite(count)}

    def path(self, root: Key, goal: Key, *, over_taken: bool) -> list[Key] | None:
        """Return the places on the shortest way from `root` to `goal`, both included; None if there is none.

        Parameters
        ----------
        root, goal : Key
        over_taken : bool
            Whether the way may lead over places whose robots are still on their way there, or not yet found.
        """
        _, before, keys = self._searched(root, over_taken=over_taken, by_length=True)
        if root not in keys or goal not in keys or (goal != root and before[keys.index(goal)] < 0):
            return None
        row = keys.index(goal)
        way = [goal]
        while keys[row] != root:
            row = int(before[row])
            way.append(keys[row])
        return way[::-1]

    def before(self, root: Key, goal: Key) -> Key | None:
        """Return the last place before `goal` on the shortest way from `root` over places in any state, if any."""
        _, before, keys = self._searched(root, over_taken=True, by_length=True)
        row = before[keys.index(goal)] if goal in keys else -1
        return keys[row] if row >= 0 else None

    def after(self, root: Key, goal: Key) -> list[Key]:
        """Return the places before which `goal` is the last one."""
        _, before, keys = self._searched(root, over_taken=True, by_length=True)
        return [keys[row] for row in np.flatnonzero(before == keys.index(goal))] if goal in keys else []

    def _searched(self, root: Key, *, over_taken: bool, by_length: bool) -> Search:
        """Return distances from `root`, predecessors (negative: none), and the keys that both are for.

        A way never leads over an open place, unless `over_taken`: then all count as if held.
        """
        name = (root, over_taken, by_length)
        if name not in self._searches:
            self._searches[name] = self._search(root, over_taken=over_taken, by_length=by_length)
        return self._searches[name]

    def _search(self, root: Key, *, over_taken: bool, by_length: bool) -> Search:
        places = tuple(self.places(State.OPEN, State.TAKEN, State.HELD))
        return _search(places, root, self.link, self._spare, self.barriers, over_taken, by_length)


@lru_cache(maxsize=64)
def _search(  # noqa: PLR0913, PLR0917 - what a search follows from
    places: tuple[Place, ...],
    root: Key,
    link: float,
    spare: float,
    barriers: Barriers,
    over_taken: bool,
    by_length: bool,
) -> Search:
    """Return what `Board._searched` does; shared by all robots of one process that know the same places."""
    keys = [place.key for place in places]
    if root not in keys:
        return np.empty(0), np.empty(0, dtype=np.int64), []
    carries = np.array([over_taken or p.state is State.HELD or p.key == root for p in places])
    positions = _positions(places)
    pairs = barriers.pairs_in_sight(positions, link + spare)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[carries[both[:, 0]]]  # a way goes on only from places that carry it
    lengths = np.linalg.norm(positions[both[:, 0]] - positions[both[:, 1]], axis=1)
    costs = (lengths + SHORTEST if by_length else np.ones(len(both))) + DETOUR * (lengths > link)
    links = csr_array((costs, (both[:, 0], both[:, 1])), shape=(len(keys), len(keys)))
    distances, before = dijkstra(links, directed=True, indices=keys.index(root), return_predecessors=True)
    return distances, before.astype(np.int64), keys


def _positions(places: Iterable[Place]) -> FloatArray:
    return np.array([place.position for place in places]).reshape(-1, 3)
