"""Unfolding: the swarm leaves the leader as a copy of its layout that grows, so that no link is longer than planned.

A robot bound for place g is to be at ``root + f (g - root)``, with the same f from 0 to 1 for all. Distances between
robots are f times those of the layout, so that whoever is linked in the layout is linked all the way, whoever has not
arrived yet. It takes the time of the robot with the longest way, and the others drive more slowly.
"""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import Key, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.types import FloatArray

BESIDE = 0.2  # of the range: so near to the leader a robot must be to unfold with the others
GUARD_SIGMAS = 4.0  # of process noise that a link to the next robot toward the leader is kept short of the range


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
    """

    def __init__(  # noqa: PLR0913, PLR0917 - what a schedule follows from
        self, root: Key, goal: Key, board: Board, config: CoverageConfig, tick: int, period: float
    ) -> None:
        places = {place.key: np.array(place.position) for place in board.everything()}
        self._root, self._goal = places[root], places[goal]
        self._config, self._began = config, tick
        farthest = max(float(np.linalg.norm(place - self._root)) for place in places.values())
        self._ticks = max(1.0, farthest / (config.motion.speed_mps * period))
        way = board.path(root, goal, over_taken=True)
        self._revision = -1
        self._bound, self._ways = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        self._before = way[-2] if way is not None and len(way) > 1 else root

    def share(self, tick: int) -> float:
        """Return how large the copy of the layout is to be at the beginning of a tick, 0 to 1."""
        return min(1.0, max(0.0, (tick - self._began) / self._ticks))

    def target(self, tick: int, position: FloatArray, board: Board, around: Surroundings) -> FloatArray:
        """Return where to be at the end of a tick, (3,) [m]: on schedule, and not too far from the robot before.

        Parameters
        ----------
        tick : int
        position : (3,) array
            Where the robot is [m].
        board : Board
        around : Surroundings
        """
        target: FloatArray = self._root + self.share(tick + 1) * (self._goal - self._root)
        before = board.get(self._before)
        offset = None if before is None else around.offset(before.holder)
        if offset is None or np.linalg.norm(offset) >= self._config.range_m:  # not here: a straggler
            return target
        anchor = position + offset
        reach = self._config.range_m - GUARD_SIGMAS * self._config.motion.sigma_m
        away = target - anchor
        distance = float(np.linalg.norm(away))
        return target if distance <= reach else anchor + away * (reach / distance)

    def located(self, tick: int, board: Board, around: Surroundings) -> FloatArray | None:
        """Return where the robot is by those around it that are under way as well, (3,) [m]; None if there are none.

        Each of them is taken to be on schedule, from which it is off by the noise of one step.
        """
        if board.revision != self._revision:
            bound = sorted((place.holder, place.position) for place in board.places(State.TAKEN))
            self._bound = np.array([holder for holder, _ in bound], dtype=np.int64)
            self._ways = np.array([position for _, position in bound]).reshape(-1, 3) - self._root
            self._revision = board.revision
        _, taken, sensed = np.intersect1d(self._bound, around.ids, assume_unique=True, return_indices=True)
        if not len(taken):
            return None
        guesses = self._root + self.share(tick) * self._ways[taken] - around.offsets[sensed]
        middle: FloatArray = np.median(guesses, axis=0)  # a straggler is not on schedule, and must not count
        return middle


def may_unfold(board: Board, root: Key, away: float, config: CoverageConfig) -> bool:
    """Return whether this is the beginning, for a robot that is so far `away` from the leader [m].

    Nobody but the leader has arrived anywhere, no place was given up, and the robot is where it has to begin.
    """
    held = [place.key for place in board.held.values()]
    is_here = away <= BESIDE * config.range_m
    return is_here and held == [root] and all(place.version == 0 for place in board.everything())
