"""Rendezvous at the leader: distributed breadth-first search, then everybody visits the ancestors, leaves first."""

from __future__ import annotations

from collections.abc import Iterable

from swarm_agent.coverage.frames import NOBODY, Frame, TreeNews
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.types import NodeId

INFINITE = 0xFFFF  # hops of a robot that the search has not reached
LAST_RESORT_TICKS = 2  # without a better one, until a long edge will do
SETTLED_TICKS = 5  # without news until the children that a robot knows are all: search down, their answer back up

NO_PARENT = (INFINITE, NOBODY, 1 << 62)


class Rendezvous:
    """One robot's part in one rendezvous.

    The root has 0 hops; everybody else takes ``min(own, neighbor's + 1)`` and tells it on (eq. (6)): in synchronous
    rounds once per robot. Sizes of subtrees then go up, so that a robot knows how many descendants must visit it
    before it may leave. Who travels is always on an edge whose upper end waits for it, which keeps all linked.

    Parameters
    ----------
    me : NodeId
    is_root : bool
    term : int
        Which rendezvous; news of others are not for this one.
    """

    def __init__(self, me: NodeId, *, is_root: bool, term: int) -> None:
        self._me = me
        self._is_root = is_root
        self._term = term
        self.hops = 0 if is_root else INFINITE
        self.parent = NOBODY
        self.searches = 0
        self._last_resort = NO_PARENT  # hops, parent and since when, over an edge that is longer than is good
        self._news_at: int | None = None  # when it last heard something new; at first, when it began
        self._sizes: dict[NodeId, int] = {}
        self._parents: dict[NodeId, NodeId] = {}
        self._visitors: set[NodeId] = set()
        self._target = NOBODY
        self._said: TreeNews | None = None
        self._must_tell = is_root
        self._size = 0
        self._met = NOBODY

    @property
    def size(self) -> int:
        """Robots in the own subtree, itself included; 0 while unknown."""
        return self._size

    @property
    def target(self) -> NodeId:
        """Ancestor to drive to now, `NOBODY` while waiting for descendants or for the next ancestor's name."""
        return self._target

    @property
    def met(self) -> NodeId:
        """Ancestor met last, the root in the end; `NOBODY` before the first."""
        return self._met

    def hear(self, tick: int, frames: Iterable[Frame], around: Surroundings, link: float) -> None:
        """Take in what neighbors say of the tree.

        Parameters
        ----------
        tick : int
        frames : iterable of Frame
        around : Surroundings
        link : float
            Longest edge of the tree, where there is a choice [m]: somewhat less than the range, because who travels
            along it may be off.
        """
        for frame in frames:
            news = frame.tree
            if news is None or news.term != self._term:
                continue
            self._parents[frame.sender] = news.parent
            if news.hops + 1 < self.hops and not self._size:  # afterward, the parent counts on it
                if around.distance(frame.sender) <= link:
                    self._take(news.hops + 1, frame.sender, tick)
                elif self.hops == INFINITE:
                    self._last_resort = min(self._last_resort, (news.hops + 1, frame.sender, tick))
            if self._size:
                pass  # whoever comes by now is another's descendant
            elif news.parent == self._me and self._sizes.get(frame.sender) != news.size:
                self._sizes[frame.sender], self._news_at = news.size, tick
            elif news.parent != self._me and self._sizes.pop(frame.sender, None) is not None:
                self._news_at = tick
            if news.met == self._me:
                self._visitors.add(frame.sender)
                self._must_tell = True  # so that the visitor learns where to go next

    def _take(self, hops: int, parent: NodeId, tick: int) -> None:
        self.hops, self.parent = hops, parent
        self._must_tell, self._news_at = True, tick

    def advance(self, tick: int, around: Surroundings, meeting: float) -> bool:
        """Decide what to do; return whether the root has been met (or, of the root, whether all have come).

        Parameters
        ----------
        tick : int
        around : Surroundings
        meeting : float
            Nearer than this is met [m].
        """
        hops, parent, heard_at = self._last_resort
        if self.hops == INFINITE and tick - heard_at >= LAST_RESORT_TICKS:
            self._take(hops, parent, tick)
        if self.hops == INFINITE or not self._is_complete(tick):
            return False
        everybody_came = len(self._visitors) >= self.size - 1
        if self._is_root:
            return everybody_came
        if self._target == NOBODY and self._met == NOBODY and everybody_came:
            self._target = self.parent
        if self._target != NOBODY and around.distance(self._target) <= meeting:
            self._met, self._target = self._target, NOBODY
            self._must_tell = True
        if self._met != NOBODY and self._target == NOBODY:
            upward = self._parents.get(self._met)
            if upward == NOBODY:
                return True
            if upward is not None:
                self._target = upward
        return False

    def news(self) -> TreeNews | None:
        """Return what must be said now, None if nothing."""
        said = TreeNews(self._term, self.hops, self.parent, self.size, self._met)
        if self.hops == INFINITE or (said == self._said and not self._must_tell):
            return None
        self.searches += self._said is None or self._said.hops != said.hops
        self._said, self._must_tell = said, False
        return said

    def _is_complete(self, tick: int) -> bool:
        """Return whether all of the subtree is known, and note its size."""
        if self._news_at is None:
            self._news_at = tick
        if not self._size and tick - self._news_at >= SETTLED_TICKS and all(self._sizes.values()):
            self._size = 1 + sum(self._sizes.values())
        return self._size > 0
