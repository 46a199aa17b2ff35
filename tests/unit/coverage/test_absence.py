"""Who is gone: seen to vanish, vanished before it was heard of, or on its way for too long."""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.absence import AbsenceWatch
from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import Place, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.coverage_io import CoverageInputs
from swarm_msgs_py.types import FloatArray, NodeId

HERE = np.zeros(3)
CONFIG = CoverageConfig()
TAKEN = Place((NodeId(0), 1), 0, State.TAKEN, NodeId(5), (60.0, 0.0, 0.0))


def around(tick: int, robots: dict[int, FloatArray]) -> Surroundings:
    ids = np.array(sorted(robots), dtype=np.int64)
    offsets = np.array([robots[robot] for robot in sorted(robots)]).reshape(-1, 3)
    return Surroundings(CoverageInputs(tick, float(tick), ids, offsets, (), None))


def gone(watch: AbsenceWatch, board: Board, sensed: list[dict[int, FloatArray]]) -> list[int]:
    """Return the ticks in which the robot of `TAKEN` counts as gone."""
    return [tick for tick, robots in enumerate(sensed) if TAKEN in watch.gone(tick, HERE, board, around(tick, robots))]


def test_a_robot_that_died_before_it_was_heard_to_have_taken_a_place_is_missed() -> None:
    watch, board = AbsenceWatch(NodeId(0), CONFIG, 1.0), Board(48.0)

    assert gone(watch, board, [{5: np.array([30.0, 0.0, 0.0])}, {}]) == []
    board.merge(TAKEN)

    assert gone(watch, board, [{}] * 5) == [CONFIG.protocol.absence_ticks - 1, 3, 4]


def test_a_robot_that_left_for_where_nobody_senses_it_is_given_its_time() -> None:
    watch, board = AbsenceWatch(NodeId(0), CONFIG, 1.0), Board(48.0)
    board.merge(Place((NodeId(0), 0), 0, State.HELD, NodeId(0), (0.0, 0.0, 0.0)))
    board.merge(TAKEN)
    way = [{5: np.array([x, 0.0, 0.0])} for x in (80.0, 95.0)]

    missed = gone(watch, board, [*way, *[{}] * 200])

    assert CONFIG.protocol.travel_limit * 60.0 / CONFIG.motion.speed_mps < min(missed) < 120
