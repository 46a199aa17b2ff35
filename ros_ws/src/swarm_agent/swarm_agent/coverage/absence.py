"""Who is gone: robots that must be sensed, and are not."""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig, ProtocolConfig
from swarm_agent.coverage.frames import NOBODY, Place
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.types import FloatArray, NodeId

HIDDEN = 10  # times as patient with robots under way, where obstacles may hide them
WINDING = 2.0  # a way is taken to be so many times as long as it is straight from the farthest robot


def patience_under_way(protocol: ProtocolConfig, barriers: Barriers) -> int:
    """Return for how many ticks a robot that travels must not be sensed until it is taken for gone."""
    return protocol.absence_ticks * (HIDDEN if barriers else 1)


class AbsenceWatch:
    """Finds places whose robots have vanished.

    A robot senses all others within 2 r_sc. One that holds a place well within that, or that is on its way to a place
    and was well within that when last sensed, and is not sensed for some ticks, does not exist any more. That it is on
    its way may be heard after it has died. Who has been on its way for longer than it would go on itself [I9] has died
    where nobody saw it.

    Parameters
    ----------
    me : NodeId
    config : CoverageConfig
    period : float
        Of a tick [s].
    barriers : Barriers, optional
        Obstacles that hide robots.
    """

    def __init__(self, me: NodeId, config: CoverageConfig, period: float, barriers: Barriers = OPEN_SPACE) -> None:
        self._me = me
        self._barriers = barriers
        self._step_m = config.motion.speed_mps * period
        self._travel_limit, self._delay_ticks = config.protocol.travel_limit, config.protocol.heartbeat_ticks
        self._patience = config.protocol.absence_ticks
        self._patience_under_way = patience_under_way(config.protocol, barriers)
        self._reach = config.protocol.absence_share * config.range_m
        self._missed: dict[NodeId, int] = {}
        self._inside: set[NodeId] = set()  # who was well within when last sensed
        self._near: dict[NodeId, Place] = {}
        self._due: dict[NodeId, int] = {}  # until when travelers are waited for
        self._accounted = 0  # of those whose places have changed

    def gone(self, tick: int, position: FloatArray, board: Board, around: Surroundings) -> list[Place]:
        """Return the records of places whose robots are gone.

        Parameters
        ----------
        tick : int
        position : (3,) array
            Own place [m].
        board : Board
        around : Surroundings
        """
        self._look_up(tick, position, board)
        self._inside -= around.robots.keys()
        self._inside.update(around.ids[around.distances < self._reach].tolist())
        expected = self._near.keys() | (self._inside & self._due.keys())
        missing = expected - around.robots.keys()
        self._missed = {robot: self._missed.get(robot, 0) + 1 for robot in missing}
        lost = {
            robot
            for robot, ticks in self._missed.items()
            if ticks >= (self._patience if robot in self._near else self._patience_under_way)
        }
        lost.update(robot for robot, due in self._due.items() if tick > due)
        return [self._near.get(robot) or board.bound[robot] for robot in sorted(lost)]

    def _look_up(self, tick: int, position: FloatArray, board: Board) -> None:
        """Note who must be near, and who is under way, among those whose places have changed."""
        if self._accounted == len(board.touched):
            return
        changed = sorted(set(board.touched[self._accounted :]) - {self._me, NOBODY})
        self._accounted = len(board.touched)
        for robot in changed:
            self._near.pop(robot, None)
            self._due.pop(robot, None)
            if robot in board.bound:
                self._due[robot] = tick + self._patience_with(board.bound[robot], board.held_positions)
        robots = [robot for robot in changed if robot in board.held]
        places = np.array([board.held[robot].position for robot in robots]).reshape(-1, 3)
        near = np.linalg.norm(places - position, axis=1) < self._reach
        if self._barriers:
            near &= ~self._barriers.cut(np.broadcast_to(position, places.shape), places)
        self._near |= {robots[row]: board.held[robots[row]] for row in np.flatnonzero(near)}

    def _patience_with(self, place: Place, held: FloatArray) -> int:
        """Return how long a robot can be on its way to a place from among those that hold theirs [ticks]."""
        farthest = float(np.linalg.norm(held - np.array(place.position), axis=1).max(initial=0.0))
        return int(self._travel_limit * (WINDING * farthest / self._step_m + self._delay_ticks))
