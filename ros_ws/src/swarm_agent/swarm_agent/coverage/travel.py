"""The way to a place: over places that are held, so that the traveler is linked to one of them at every tick."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig, Expansion
from swarm_agent.coverage.frames import Key, Place, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.types import FloatArray

GATE_SIGMAS = 4.0  # a robot that hovers this near its place carries a link before it has settled
GATE_SHARE = 0.02  # of the range; the same, where there is no noise
SPACING = 0.1  # of the range, between the points of a short cut that are looked at


class Travel:
    """One robot's way from the place next to it to the place that it has taken.

    Parameters
    ----------
    goal : Place
    anchor : Key
        Place from which it sets out: that of a robot linked to it.
    config : CoverageConfig
    """

    def __init__(self, goal: Place, anchor: Key, config: CoverageConfig) -> None:
        self.goal = goal
        self._anchor = anchor
        self._config = config
        self._way: list[Key] | None = None
        self._revision = -1
        self.ticks = 0

    def target(self, position: FloatArray, board: Board, around: Surroundings) -> FloatArray | None:
        """Return where to drive now, (3,) [m]; None to wait, for there is no way or it is not safe to go on.

        Parameters
        ----------
        position : (3,) array
            Where it is [m].
        board : Board
        around : Surroundings
        """
        self.ticks += 1
        if board.revision != self._revision:
            way = board.path(self._anchor, self.goal.key, over_taken=self._predicts)
            # The ball of links around the anchor is convex, so that one may turn to any neighbor of it from anywhere.
            self._way = None if way is None else way[1:] or way
            self._revision = board.revision
        if self._way is None:
            return None
        if not board.barriers and self._is_carried(position, np.array(self.goal.position), board):
            return np.array(self.goal.position)
        nearby = self._config.motion.turning_m
        while len(self._way) > 1:
            anchor = board.get(self._way[0])
            if anchor is None or np.linalg.norm(np.array(anchor.position) - position) > nearby:
                break
            if not self._carries(anchor, position, around):
                return None
            self._way = self._way[1:]
            self._anchor = anchor.key
        target = board.get(self._way[0])
        return None if target is None else np.array(target.position)

    def expected_ticks(self, board: Board, period: float) -> float:
        """Return how long the way takes at full speed [ticks]."""
        way = board.path(self._anchor, self.goal.key, over_taken=self._predicts) or []
        places = np.array([place.position for key in way if (place := board.get(key))]).reshape(-1, 3)
        length = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
        return length / (self._config.motion.speed_mps * period)

    @property
    def _predicts(self) -> bool:
        return self._config.expansion is Expansion.PREDICTED

    @property
    def _slack(self) -> float:
        """How far a robot may be from where it means to be [m]."""
        return max(GATE_SIGMAS * self._config.motion.sigma_m, GATE_SHARE * self._config.range_m)

    def _is_carried(self, position: FloatArray, goal: FloatArray, board: Board) -> bool:
        """Return whether the straight way to `goal` leads through the links of robots that hold their places."""
        count = int(np.ceil(np.linalg.norm(goal - position) / (SPACING * self._config.range_m)))
        points = position + np.linspace(0.0, 1.0, count + 1)[:, None] * (goal - position)
        reach = self._config.range_m - self._slack
        distances = cdist(points, board.held_positions).min(axis=1)
        # Links at both ends are as long as they are: there is nothing to choose.
        is_end = cdist(points, np.stack([position, goal])).min(axis=1) <= self._slack
        return bool((distances - np.where(is_end, self._slack, 0.0) <= reach).all())

    def _carries(self, place: Place, position: FloatArray, around: Surroundings) -> bool:
        """Return whether a robot at `place` keeps those linked that go on from there."""
        if place.state is State.HELD:
            return True
        offset = around.offset(place.holder)
        if place.state is not State.TAKEN or offset is None:
            return False
        away = float(np.linalg.norm(position + offset - np.array(place.position)))
        return away <= self._slack
