"""Boards agree whatever the order of frames, and know the ways over places that are held."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.frames import (
    NOBODY,
    Frame,
    Mission,
    Place,
    State,
    TreeNews,
    decode,
    encode,
)
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.types import NodeId

places = st.builds(
    Place,
    key=st.tuples(st.integers(0, 2).map(NodeId), st.integers(0, 2)),
    version=st.integers(0, 2),
    state=st.sampled_from(State),
    holder=st.integers(0, 4).map(NodeId),
    position=st.just((1.0, 2.0, 3.0)),
)


def at(number: int, x: float, state: State, holder: int = 0xFFFF) -> Place:
    return Place((NodeId(0), number), 0, state, NodeId(holder), (x, 0.0, 0.0))


@given(st.lists(places, max_size=12), st.randoms(use_true_random=False))
@settings(max_examples=40)
def test_boards_that_heard_the_same_records_are_equal(records: list[Place], rng) -> None:
    shuffled = [*records, *records]
    rng.shuffle(shuffled)
    first, second = Board(1.0), Board(1.0)
    for record in records:
        first.merge(record)
    for record in shuffled:
        second.merge(record)

    # Records of equal rank differ in nothing, for a place does not move without a new version.
    assert first.everything() == second.everything()
    assert first.digest == second.digest
    assert dict(first.held).keys() == {p.holder for p in first.places(State.HELD)}


def test_of_two_robots_that_take_one_place_the_higher_number_gets_it() -> None:
    board = Board(1.0)
    board.merge(at(1, 0.0, State.TAKEN, holder=3))

    assert board.merge(at(1, 0.0, State.TAKEN, holder=7))
    assert not board.merge(at(1, 0.0, State.TAKEN, holder=5))


def test_a_way_leads_over_places_that_are_held() -> None:
    board = Board(1.0)
    for number, state in enumerate([State.HELD, State.HELD, State.TAKEN, State.OPEN]):
        board.merge(at(number, 0.9 * number, state, holder=number))
    root = (NodeId(0), 0)

    assert board.path(root, (NodeId(0), 2), over_taken=False) == [(0, 0), (0, 1), (0, 2)]
    assert board.path(root, (NodeId(0), 3), over_taken=False) is None
    assert board.path(root, (NodeId(0), 3), over_taken=True) == [(0, 0), (0, 1), (0, 2), (0, 3)]
    assert board.hops_from(root, over_taken=True) == {(0, 0): 0, (0, 1): 1, (0, 2): 2, (0, 3): 3}


def test_a_freed_place_is_on_no_way_if_it_is_withdrawn() -> None:
    board = Board(1.0)
    board.merge(at(0, 0.0, State.HELD, holder=0))
    board.merge(at(1, 0.9, State.HELD, holder=1))
    place = board.get((NodeId(0), 1))
    assert place is not None

    board.merge(board.freed(place, State.WITHDRAWN))

    assert board.path((NodeId(0), 0), (NodeId(0), 1), over_taken=True) is None
    assert NodeId(1) not in board.held


def test_a_link_that_may_not_hold_is_taken_where_there_is_no_other() -> None:
    board, root = Board(1.0, spare=0.1), (NodeId(0), 0)
    board.merge(at(0, 0.0, State.HELD, holder=0))
    board.merge(at(2, 1.05, State.HELD, holder=2))
    board.merge(at(3, 2.2, State.OPEN))

    assert board.path(root, (NodeId(0), 2), over_taken=False) == [(0, 0), (0, 2)]
    assert (0, 3) not in board.hops_from(root, over_taken=True)

    board.merge(at(1, 0.5, State.HELD, holder=1))

    assert board.path(root, (NodeId(0), 2), over_taken=False) == [(0, 0), (0, 1), (0, 2)]
    assert board.hops_from(root, over_taken=False)[NodeId(0), 2] == 2


FRAME = Frame(
    NodeId(7),
    CoverageMode.HOLDING,
    0xDEADBEEF,
    is_heartbeat=True,
    places=(at(1, 2.5, State.HELD, 7), at(2, 5.0, State.OPEN)),
    tree=TreeNews(3, 2, NodeId(1), 4, NOBODY),
    mission=Mission(4, NodeId(0), b"shape"),
)


@pytest.mark.parametrize("frame", [FRAME, Frame(NodeId(1), CoverageMode.WAITING, 0, False, (), None, None)])
def test_a_frame_survives_the_air(frame: Frame) -> None:
    assert decode(encode(frame)) == frame


@given(st.binary(max_size=80))
def test_bytes_that_are_no_frame_are_refused(data: bytes) -> None:
    with pytest.raises(FrameError):
        decode(b"\x09" + data)


@given(st.integers(0, len(encode(FRAME)) - 1))
@settings(max_examples=60)
def test_a_frame_cut_short_is_refused(size: int) -> None:
    with pytest.raises(FrameError):
        decode(encode(FRAME)[:size])


def test_a_place_at_no_number_is_refused() -> None:
    bad = Place((NodeId(0), 1), 0, State.OPEN, NOBODY, (float(np.nan), 0.0, 0.0))
    data = encode(Frame(NodeId(1), CoverageMode.HOLDING, 0, False, (bad,), None, None))

    with pytest.raises(FrameError):
        decode(data)


def test_boards_that_lack_the_same_news_of_two_places_differ() -> None:
    known, behind = Board(1.0), Board(1.0)
    for number in (6, 7):
        taken = at(number, float(number), State.TAKEN, holder=number)
        behind.merge(taken)
        known.merge(taken)
        known.merge(at(number, float(number), State.HELD, holder=number))

    assert known.digest != behind.digest
