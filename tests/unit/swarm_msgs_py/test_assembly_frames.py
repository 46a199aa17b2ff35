"""Frames of boats that follow timed guideposts, and the orders of the mission computer."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_timed_paths
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_msgs_py.assembly.faces import Face, Gender
from swarm_msgs_py.assembly.orders import GuidedOrders, Order, TimedOrders, decode_order, encode_order
from swarm_msgs_py.assembly.plan import Guideposts
from swarm_msgs_py.assembly.progress_frames import ProgressFrame, decode_progress_frame, encode_progress_frame
from swarm_msgs_py.errors import FrameError


@cache
def orders(gender: Gender = Gender.OPPOSITE) -> TimedOrders:
    problem = load_problem("map_1", gender)
    plan = plan_with_timed_paths(problem, 1, TimedPlannerLimits(dispatches=1, timed=TimedLimits(attempts=2)))
    assert plan.paths is not None
    return TimedOrders(problem, plan.dispatch, plan.tree, plan.paths, 7)


@pytest.mark.parametrize("gender", list(Gender))
def test_a_plan_arrives_as_it_was_sent(gender: Gender) -> None:
    sent = orders(gender)

    got = decode_order(encode_order(Order(7, sent))).plan

    assert isinstance(got, TimedOrders)
    assert (got.dispatch, got.tree, got.epoch) == (sent.dispatch, sent.tree, 7)
    assert np.array_equal(got.paths.cells, sent.paths.cells)
    assert (got.problem.targets, got.problem.starts) == (sent.problem.targets, sent.problem.starts)
    assert (got.problem.layouts, got.problem.gender) == (sent.problem.layouts, gender)


def test_guideposts_arrive_as_they_were_sent() -> None:
    timed = orders()
    posts = Guideposts(tuple((node - 3, -node) for node in range(len(timed.tree.nodes))))
    sent = GuidedOrders(timed.problem, timed.dispatch, timed.tree, posts, 2)

    got = decode_order(encode_order(Order(2, sent))).plan

    assert isinstance(got, GuidedOrders)
    assert (got.guideposts, got.dispatch, got.tree, got.epoch) == (posts, sent.dispatch, sent.tree, 2)
    assert got.problem.starts == sent.problem.starts


def test_a_stop_is_four_bytes() -> None:
    data = encode_order(Order(3, None))

    assert len(data) == 4
    assert decode_order(data) == Order(3, None) or decode_order(data).plan is None


def test_a_progress_frame_arrives_as_it_was_sent() -> None:
    frame = ProgressFrame(3, 2, 17, 4000, frozenset({Face.UP, Face.RIGHT}), is_halted=True, is_stuck=True)

    assert decode_progress_frame(encode_progress_frame(frame)) == frame


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.binary(max_size=60), st.booleans())
def test_noise_is_refused_and_breaks_nothing(noise: bytes, is_order_like: bool) -> None:
    data = (b"\x92\x01" if is_order_like else b"\x91") + noise
    try:
        decode_order(data) if is_order_like else decode_progress_frame(data)
    except FrameError:
        return
    assert not is_order_like
    assert len(noise) == 11


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 10_000), st.integers(1, 255))
def test_an_order_with_a_flipped_byte_is_refused(place: int, flip: int) -> None:
    data = bytearray(encode_order(Order(7, orders())))
    place = 4 + place % (len(data) - 4)
    data[place] ^= flip

    with pytest.raises(FrameError):
        decode_order(bytes(data))
