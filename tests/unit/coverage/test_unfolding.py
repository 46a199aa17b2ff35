"""Unfolding: on schedule, never by a step that could break a link, and at rest where one has to be."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import Place, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_agent.coverage.unfolding import Link, Unfolding
from swarm_msgs_py.coverage_io import CoverageInputs
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, NodeId

ROOT, MIDDLE, END = ((NodeId(0), number) for number in range(3))
LATE = 100  # a tick by which all have had the time to arrive


def chain() -> Board:
    """A leader, and two robots bound for places 45 m and 90 m away from it."""
    board = Board(48.0)
    board.merge(Place(ROOT, 0, State.HELD, NodeId(0), (0.0, 0.0, 0.0)))
    board.merge(Place(MIDDLE, 0, State.TAKEN, NodeId(1), (45.0, 0.0, 0.0)))
    board.merge(Place(END, 0, State.TAKEN, NodeId(2), (90.0, 0.0, 0.0)))
    return board


def seen(offsets: dict[int, float]) -> Surroundings:
    """Robots at these offsets along the chain [m]."""
    at = np.array([[offset, 0.0, 0.0] for offset in offsets.values()])
    return Surroundings(CoverageInputs(LATE, float(LATE), np.array(list(offsets)), at, None, ()))


def aim(of: tuple[NodeId, int], x: float, offsets: dict[int, float], *, is_exact: bool) -> float:
    """Where along the chain a robot at `x` means to be next [m]."""
    board = chain()
    unfolding = Unfolding(ROOT, of, board, CoverageConfig(), 0, 1.0)
    here: FloatArray = np.array([x, 0.0, 0.0])
    return float(unfolding.target(LATE, here, board, seen(offsets), is_exact=is_exact)[0])


def test_a_robot_that_only_guesses_rests_where_it_has_to_be() -> None:
    assert aim(END, 89.0, {1: -45.0}, is_exact=False) == 89.0
    assert aim(END, 89.0, {1: -44.0}, is_exact=True) == pytest.approx(90.0)


def test_a_stretched_link_calls_the_robot_behind() -> None:
    assert aim(END, 89.0, {1: -45.8}, is_exact=False) == pytest.approx(88.2)


def test_no_step_breaks_the_link_to_a_robot_behind() -> None:
    assert aim(MIDDLE, 39.0, {0: -39.0, 2: -45.0}, is_exact=True) == pytest.approx(39.5)


def test_a_step_is_cut_where_the_link_is_longest() -> None:
    rng = rng_for(0, "links")
    for _ in range(50):
        offset, step = 5.0 * rng.normal(size=(2, 3))
        distance = float(np.linalg.norm(offset))
        link = Link(offset, distance, distance, distance + rng.random())
        share = link.share_of(step)
        assert share >= 0.0
        assert np.linalg.norm(offset - share * step) == pytest.approx(link.longest)
