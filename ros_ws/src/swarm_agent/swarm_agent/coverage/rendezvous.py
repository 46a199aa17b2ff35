"""Rendezvous at the leader: distributed breadth-first search, then everybody visits the ancestors, leaves first."""

from __future__ import annotations

from collections.abc import Iterable

from swarm_agent.coverage.frames import NOBODY, Frame, TreeNews
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.types import NodeId

INFINITE = 0xFFFF  # hops of a robot that the search has not reached
LAST_RESORT_TICKS = 2  # without a better one, until a long edge will do
SETTLED_TICKS = 5  # without news until the children that a robot knows are all: search down, their answer back up
RETELL_TICKS = 10  # what has been said is said again after so long, for frames may be lost
UNREACHED_EDGES = 3  # times as long as an edge takes, until a robot that the search has not reached looks for others

NO_PARENT = (INFINITE, NOBODY, 1 << 62)


class Rendezvous:
    """One robot's part in one rendezvous.

    The root has 0 hops; everybody else takes ``min(own, neighbor's + 1)`` and tells it on (eq. (6)): in synchronous
    rounds once per robot. Sizes of subtrees then go up, so that a robot knows how many descendants must visit it
    before it may leave. Who travels is always on an edge whose upper end waits for it, which keeps all linked.

    Robots may die meanwhile. All within two ranges are sensed, so that one that is not sensed any more is gone: nobody
    counts on it, and who was on the way to it goes to the one above it, or to others that are still there. A robot
    whose descendants do not come as counted waits until nobody is seen to come for as long as an edge takes.

    Parameters
    ----------
    me : NodeId
    is_root : bool
    term : int
        Which rendezvous; news of others are not for this one.
    absence_ticks : int
        Who is not sensed for so long is gone.
    edge_ticks : int
        How long it takes to travel along an edge.
    """

    def __init__(self, me: NodeId, *, is_root: bool, term: int, absence_ticks: int, edge_ticks: int) -> None:
        self._me = me
        self._is_root = is_root
        self._term = term
        self._absence_ticks, self._edge_ticks = absence_ticks, edge_ticks
        self.hops = 0 if is_root else INFINITE
        self.parent = NOBODY
        self.searches = 0
        self._last_resort = NO_PARENT  # hops, parent and since when, over an edge that is longer than is good
        self._news_at: int | None = None  # when it last heard something new; at first, when it began
        self._sizes: dict[NodeId, int] = {}
        self._parents: dict[NodeId, NodeId] = {}
        self._met_by: dict[NodeId, NodeId] = {}  # whom each neighbor has met last
        self._missed: dict[NodeId, int] = {}  # ticks without a sign of those that this one counts on
        self._quiet_ticks = 0  # in which nobody was coming
        self._unreached_ticks = 0
        self._visitors: set[NodeId] = set()
        self._target = NOBODY
        self._said: TreeNews | None = None
        self._said_at = 0
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
            self._parents[frame.sender], self._met_by[frame.sender] = news.parent, news.met
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
        self.hops, self.parent, self._target = hops, parent, NOBODY
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
        self._forget_the_gone(tick, around)
        if self.hops == INFINITE:
            self._unreached_ticks += 1
            if self._unreached_ticks > UNREACHED_EDGES * self._edge_ticks:
                self._target = self._somebody(around)
            return False
        if not self._is_complete(tick):
            return False
        everybody_came = len(self._visitors) >= self.size - 1 or self._nobody_comes(around, meeting)
        if self._is_root:
            return everybody_came
        if self._target == NOBODY and self._met == NOBODY and everybody_came:
            self._target = self.parent
        if self._target != NOBODY and around.distance(self._target) <= meeting:
            self._met, self._target = self._target, NOBODY
            self._must_tell = True
        if self._met != NOBODY and self._target == NOBODY:
            upward = self._parents.get(self._met)
            if upward is None and self._is_gone(self._met):
                upward = self._somebody(around)
            if upward == NOBODY:
                return True
            if upward is not None:
                self._target = upward
        return False

    def news(self, tick: int) -> TreeNews | None:
        """Return what must be said now, None if nothing."""
        said = TreeNews(self._term, self.hops, self.parent, self.size, self._met)
        is_due = tick - self._said_at >= RETELL_TICKS
        if self.hops == INFINITE or (said == self._said and not self._must_tell and not is_due):
            return None
        self.searches += self._said is None or self._said.hops != said.hops
        self._said, self._said_at, self._must_tell = said, tick, False
        return said

    def _forget_the_gone(self, tick: int, around: Surroundings) -> None:
        """Count no more on robots that have not been sensed for a while."""
        expected = {self.parent, self._target, self._met, *self._sizes} - {NOBODY}
        self._missed = {robot: self._missed.get(robot, 0) + 1 for robot in expected - around.robots.keys()}
        for robot in sorted(filter(self._is_gone, self._missed)):
            if not self._size and self._sizes.pop(robot, None) is not None:
                self._news_at = tick
            if robot in {self.parent, self._target}:
                above = self._parents.get(robot, NOBODY)
                heir = above if above in around.robots else self._somebody(around)
                self._target = heir if robot == self._target else self._target
                self.parent = heir if robot == self.parent else self.parent
                self._must_tell = True

    def _is_gone(self, robot: NodeId) -> bool:
        return self._missed.get(robot, 0) >= self._absence_ticks

    def _somebody(self, around: Surroundings) -> NodeId:
        """Return the nearest robot that is not on the way to this one, `NOBODY` if none is sensed."""
        others = [
            (away, robot)
            for robot, away in zip(around.robots, around.distances.tolist(), strict=True)
            if self._parents.get(robot) != self._me
        ]
        return min(others, default=(0.0, NOBODY))[1]

    def _nobody_comes(self, around: Surroundings, meeting: float) -> bool:
        """Return whether for a while nobody has been sensed that is still to come.

        To a robot come its children, and who has met one of those; to the root comes everybody.
        """
        is_quiet = all(
            robot in self._visitors or away <= meeting or not self._is_coming(robot)
            for robot, away in zip(around.robots, around.distances.tolist(), strict=True)
        )
        self._quiet_ticks = self._quiet_ticks + 1 if is_quiet else 0
        return self._quiet_ticks > self._edge_ticks + SETTLED_TICKS

    def _is_coming(self, robot: NodeId) -> bool:
        met = self._met_by.get(robot, NOBODY)  # who has met one further up has been here, though that was not heard
        is_child = met == NOBODY and self._parents.get(robot) == self._me
        return self._is_root or is_child or self._parents.get(met) == self._me

    def _is_complete(self, tick: int) -> bool:
        """Return whether all of the subtree is known, and note its size."""
        if self._news_at is None:
            self._news_at = tick
        if not self._size and tick - self._news_at >= SETTLED_TICKS and all(self._sizes.values()):
            self._size = 1 + sum(self._sizes.values())
        return self._size > 0
