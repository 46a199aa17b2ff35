"""Unfolding: the swarm leaves the leader as a copy of its layout that grows, so that no link is longer than planned.

A robot bound for place g is to be at ``root + f (g - root)``, with the same f from 0 to 1 for all. Distances between
robots are f times those of the layout, so that whoever is linked in the layout is linked all the way, whoever has not
arrived yet. It takes the time of the robot with the longest way, and the others drive more slowly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import Key, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.types import FloatArray

BESIDE = 0.2  # of the range: so near to the leader a robot must be to unfold with the others
RESERVE = 0.05  # of the time: at full speed, the robot with the longest way could not make up for noise
BROKEN = 1.1  # in ranges: a robot no farther than this was linked a moment ago
GUARD_SIGMAS = 4.0  # of process noise that a link of the tree is kept short of the range


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A link of the layout to a robot that is here.

    Attributes
    ----------
    offset : (3,) array
        Of the other robot [m].
    distance : float
        Of it [m].
    reach : float
        Farther from it a robot does not mean to be [m].
    longest : float
        Farther from it no step leads, whatever other links ask for [m]; at least `distance`.
    """

    offset: FloatArray
    distance: float
    reach: float
    longest: float

    def share_of(self, step: FloatArray) -> float:
        """Return how much of a step (3,) [m] may be taken so that the link gets no longer than `longest`."""
        square = float(step @ step)
        if square == 0.0:
            return 1.0
        along = float(step @ self.offset) / square
        return along + float(np.sqrt(max(0.0, along**2 + (self.longest**2 - self.distance**2) / square)))


class Unfolding:
    """One robot's part in an unfolding that begins now.

    Parameters
    ----------
    root, goal : Key
        Places of the leader and of this robot.
    board : Board
        Must know both.
    config : CoverageConfig
    tick : int
        The present one.
    period : float
        Of a tick [s].

    Attributes
    ----------
    ticks : float
        How long it takes.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - what a schedule follows from
        self, root: Key, goal: Key, board: Board, config: CoverageConfig, tick: int, period: float
    ) -> None:
        places = {place.key: np.array(place.position) for place in board.everything()}
        self._root, self._goal = places[root], places[goal]
        self._config, self._began = config, tick
        farthest = max(float(np.linalg.norm(place - self._root)) for place in places.values())
        self.ticks = max(1.0, (1.0 + RESERVE) * farthest / (config.motion.speed_mps * period))
        self._arrival = max(config.motion.arrival_m, config.motion.arrival_sigmas * config.motion.sigma_m)
        linked = (*board.after(root, goal), board.before(root, goal) or root)
        self._linked = [(key, float(np.linalg.norm(places[key] - self._goal))) for key in linked]
        noise = GUARD_SIGMAS * config.motion.sigma_m
        self._reach, self._reach_under_way = config.range_m - noise, config.range_m - np.sqrt(2.0) * noise

    def share(self, tick: int) -> float:
        """Return how large the copy of the layout is to be at the beginning of a tick, 0 to 1."""
        return min(1.0, max(0.0, (tick - self._began) / self.ticks))

    def target(
        self, tick: int, position: FloatArray, board: Board, around: Surroundings, *, is_exact: bool
    ) -> FloatArray:
        """Return where to be at the end of a tick, (3,) [m]: on schedule, and not too far from linked robots.

        The robot before counts most. Who is where it has to be in the end waits there: only who moves is shaken, and
        far out it takes a while until robots at their places tell who has come.

        Parameters
        ----------
        tick : int
        position : (3,) array
            Where the robot is [m].
        board : Board
        around : Surroundings
        is_exact : bool
            Whether a robot at its place has told the position.
        """
        target: FloatArray = self._root + self.share(tick + 1) * (self._goal - self._root)
        links = self._links(board, around)
        for link in links:
            away = target - position - link.offset
            wanted = float(np.sqrt(away @ away))
            if wanted > link.reach:
                target = position + link.offset + away * (link.reach / wanted)
        step = target - position
        # A robot before that has to go on stretches the link beyond this, and so calls the one behind.
        is_slack = all(2.0 * link.distance <= link.reach + self._reach for link in links[-1:])
        if is_slack and self.share(tick) >= 1.0 and not is_exact and np.linalg.norm(step) <= self._arrival:
            return position
        return position + min([1.0, *(link.share_of(step) for link in links)]) * step

    def _links(self, board: Board, around: Surroundings) -> list[Link]:
        """Return the links to linked robots that are here, that to the robot before last.

        One that is under way is shaken as well, and as free to use what is left of the link.
        """
        links = []
        for key, planned in self._linked:
            place = board.get(key)
            offset = None if place is None else around.offset(place.holder)
            if place is None or offset is None:
                continue
            distance = float(np.sqrt(offset @ offset))
            if distance >= BROKEN * self._config.range_m:  # a straggler
                continue
            if place.state is State.HELD:
                links.append(Link(offset, distance, self._reach, max(distance, self._reach)))
            else:
                is_behind = key != self._linked[-1][0]  # and is to follow, not to hold back
                reach = self._reach if is_behind else min(self._reach, max(planned, self._reach_under_way))
                links.append(Link(offset, distance, reach, max(distance, 0.5 * (distance + self._reach))))
        return links

    def located(self, tick: int, board: Board, around: Surroundings) -> FloatArray | None:
        """Return where the robot is by those around it that are under way as well, (3,) [m]; None if there are none.

        Each of them is taken to be on schedule, from which it is off by the noise of one step.
        """
        near = [(row, board.bound[robot].position) for robot, row in around.robots.items() if robot in board.bound]
        if not near:
            return None
        rows, goals = zip(*near, strict=True)
        guesses = self._root + self.share(tick) * (np.array(goals) - self._root) - around.offsets[list(rows)]
        middle: FloatArray = np.median(guesses, axis=0)  # a straggler is not on schedule, and must not count
        return middle


def may_unfold(board: Board, root: Key, away: float, config: CoverageConfig) -> bool:
    """Return whether this is the beginning, for a robot that is so far `away` from the leader [m].

    Nobody but the leader has arrived anywhere, no place was given up, and the robot is where it has to begin.
    """
    held = [place.key for place in board.held.values()]
    is_here = away <= BESIDE * config.range_m
    return is_here and held == [root] and all(place.version == 0 for place in board.everything())
