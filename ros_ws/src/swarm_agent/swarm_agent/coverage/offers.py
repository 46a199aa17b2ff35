"""Offers: a robot that holds its place names places next to it where its frontier asks for a robot."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig, Expansion, Rule
from swarm_agent.coverage.frames import NOBODY, Key, Place, State, on_air
from swarm_agent.coverage.frontier import Frontier
from swarm_agent.coverage.rules import choose
from swarm_agent.coverage.sense_sphere import TOUCHING, directions_of
from swarm_agent.coverage.sites import REACH, Site
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, NodeId

STRANDED_BEATS = 2  # for so many heartbeats there must be no way to an offer until it is withdrawn


class Offers:
    """The frontier of one robot, and the places that it has offered for it.

    A place that is taken, or offered by anybody, counts as if it were held (a *reservation*), so that no two robots
    set out for one hole. If reservations cross on the air, the later name withdraws. Robots that have no link to the
    leader any more do not count [I10]: what they cover is offered, and who goes there links them again.

    Parameters
    ----------
    me : NodeId
    place : Place
        That it holds.
    root : Key
        The leader's place.
    solid : Solid
    config : CoverageConfig
    seed : int
    barriers : Barriers, optional
        Obstacles that places and links keep clear of.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - what a frontier follows from
        self,
        me: NodeId,
        place: Place,
        root: Key,
        solid: Solid,
        config: CoverageConfig,
        seed: int,
        barriers: Barriers = OPEN_SPACE,
    ) -> None:
        self._barriers = barriers
        self._me, self._key, self._root = me, place.key, root
        self._position = np.array(place.position)
        self._solid = solid
        self._config = config
        self._directions = directions_of(config)
        self._rng = rng_for(seed, "coverage", "offers", me)
        self._targets: dict[int, FloatArray] = {}
        self._next = 1
        self._linked: dict[NodeId, Place] = {}
        self._patience = STRANDED_BEATS * config.protocol.heartbeat_ticks
        self._stranded: dict[Key, int] = {}  # since when there is no way to offers of robots that are gone
        self._revision = -1
        self.frontier = self._fresh()

    def refresh(self, tick: int, board: Board) -> list[Place]:
        """Bring the frontier up to date with the board; return what to say: places withdrawn and newly offered."""
        overdue = [key for key, since in self._stranded.items() if tick - since >= self._patience]
        if board.revision == self._revision and not overdue:
            return []
        said = self._refreshed(tick, board)
        self._revision = board.revision
        return said

    def _refreshed(self, tick: int, board: Board) -> list[Place]:
        hops = board.hops_from(self._root, over_taken=False)
        if self._key not in hops:  # nobody could come
            self._stranded = {}
            return []
        self._update({robot: place for robot, place in board.held.items() if place.key in hops})
        said = [*self._withdrawals(board), *self._given_up(tick, board, hops)]
        for place in said:
            board.merge(place)
        limit = 1 if self._config.expansion is Expansion.SERIAL else self._config.protocol.offers_max
        reserved = board.places(State.OPEN, State.TAKEN)
        own_open = sum(place.key[0] == self._me and place.state is State.OPEN for place in reserved)
        points = self._uncovered(self._in_sight(self.frontier.points), reserved)
        while len(points) and own_open < limit:
            choice = choose(self._config, self._site(points, reserved), self._rng)
            place = self._offer(points[choice.row], choice.place, board)
            reserved.append(place)
            said.append(place)
            own_open += 1
            points = self._uncovered(points, [place])
        return said

    def _update(self, linked: dict[NodeId, Place]) -> None:
        """Delete what newcomers cover; if somebody is gone, look at all samples anew."""
        before, self._linked = self._linked.keys(), linked
        if before - linked.keys():
            self.frontier = self._fresh()
        else:
            for robot in sorted(linked.keys() - before - {self._me}):
                self.frontier.delete_within(np.array(linked[robot].position) - self._position)

    def _fresh(self) -> Frontier:
        radius = self._config.range_m
        return Frontier.around(
            self._position, self._directions, radius, self._solid, self._offsets(2.0 * radius, self._position)
        )

    def _offsets(self, reach: float, center: FloatArray) -> FloatArray:
        """Return the places held by others within `reach` of `center`, relative to it, (m, 3)."""
        others = [p.position for robot, p in sorted(self._linked.items()) if robot != self._me]
        offsets = np.array(others).reshape(-1, 3) - center
        near: FloatArray = offsets[np.linalg.norm(offsets, axis=1) < reach]
        return near

    def _around(self, own: FloatArray) -> FloatArray:
        """Return the frontier points of robots within 3 r_sc, relative to this one; they follow from the board."""
        radius = self._config.range_m
        points = [own]
        for offset in self._offsets(REACH * radius, self._position):
            center = self._position + offset
            close = np.concatenate([self._offsets(2.0 * radius, center), [-offset]])
            close = close[np.linalg.norm(close, axis=1) > 0.0]
            points.append(offset + Frontier.around(center, self._directions, radius, self._solid, close).points)
        return np.concatenate(points)

    def _in_sight(self, points: FloatArray) -> FloatArray:
        """Return those of some frontier points for which a robot could stand in sight of this one."""
        if not self._barriers:
            return points
        places = self._position + self._config.placement * points
        return points[~self._barriers.cut(np.broadcast_to(self._position, places.shape), places)]

    def _uncovered(self, points: FloatArray, places: list[Place]) -> FloatArray:
        """Return those of some frontier points that a robot at each of the places would leave uncovered."""
        for place in places:
            away = points - (np.array(place.position) - self._position)
            points = points[np.linalg.norm(away, axis=1) > self._config.range_m * (1.0 + TOUCHING)]
        return points

    def _site(self, points: FloatArray, reserved: list[Place]) -> Site:
        """Return what is known around; places that are reserved count as if robots held them."""
        around = points if self._config.rule is Rule.RANDOM else self._around(points)
        others = np.concatenate([np.zeros((1, 3)), self._offsets(REACH * self._config.range_m, self._position)])
        if reserved:
            places = np.array([place.position for place in reserved]) - self._position
            others = np.concatenate([others, places])
        return Site(points, around, others, self._position, self._solid)

    def _offer(self, target: FloatArray, offset: FloatArray, board: Board) -> Place:
        position = on_air(self._position + offset)
        while board.get((self._me, self._next)) is not None:  # by itself, before it was taken for dead
            self._next += 1
        place = Place((self._me, self._next), 0, State.OPEN, NOBODY, position)
        self._targets[self._next] = target
        self._next += 1
        board.merge(place)
        return place

    def _withdrawals(self, board: Board) -> list[Place]:
        """Return own offers that others have made needless."""
        needless = []
        # Targets are on the edge of the own coverage, which must not count.
        rivals = [p for p in board.places(State.OPEN, State.TAKEN) if p.holder != self._me]
        rivals += [p for _, p in sorted(self._linked.items()) if p.holder != self._me]
        for number, target in sorted(self._targets.items()):
            place = board.get((self._me, number))
            if place is None or place.state is not State.OPEN:
                continue
            others = [p for p in rivals if p.key != place.key and (p.state is not State.OPEN or p.key < place.key)]
            if not len(self._uncovered(target[None], others)):
                needless.append(_withdrawn(place))
        return needless

    def _given_up(self, tick: int, board: Board, hops: Mapping[Key, int]) -> list[Place]:
        """Return offers to which no way leads any more, for who made them has died or is cut off; others offer anew.

        That must last, because boards differ for a while: offers that come and go would keep them from being compared.
        """
        stranded = {
            place.key: place
            for place in board.places(State.OPEN)
            if place.key not in hops and place.key[0] not in self._linked and place.key != self._root
        }
        self._stranded = {key: self._stranded.get(key, tick) for key in stranded}
        return [_withdrawn(stranded[key]) for key, since in self._stranded.items() if tick - since >= self._patience]


def _withdrawn(place: Place) -> Place:
    """Return the record that says that nobody is wanted at an open place."""
    return Place(place.key, place.version, State.WITHDRAWN, NOBODY, place.position)
