"""Laws of moving shapes over generated contours, and of plans that tell them."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from shapely import Polygon

from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError, ShapeError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.geometry.morphing import Morph
from swarm_msgs_py.messages.bodies import Motion, Plan, Task
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.plan_goals import completed
from swarm_msgs_py.plan_motion import contour_at, goal_rates_at, goals_at
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray


@st.composite
def contours(draw: st.DrawFn) -> FloatArray:
    """Star-shaped simple polygons of 3 to 12 vertices, some with deep notches, 2 to 14 m in radius, in centimeters."""
    count = draw(st.integers(3, 12))
    size = draw(st.floats(2.0, 8.0))
    stretches = draw(st.lists(st.floats(0.25, 1.75), min_size=count, max_size=count))
    shift = draw(st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0)))
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    points = (size * np.array(stretches))[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]) + shift
    return points.round(2)


@settings(max_examples=12)
@given(contours(), contours(), st.floats(-4.0, 4.0))
def test_a_morph_is_refused_or_simple_all_the_way(start: FloatArray, target: FloatArray, rotation: float) -> None:
    try:
        morph = Morph(start, target, rotation)
    except ShapeError:
        assume(False)
    first, last = signed_area(start), signed_area(target)

    for share in np.arange(25) / 24.0:
        contour = morph.at(share)
        blend = share * share * (3.0 - 2.0 * share)
        assert Polygon(contour).is_valid
        assert abs(signed_area(contour) - (first + blend * (last - first))) < 0.01 * (first + last)


@settings(max_examples=12)
@given(contours(), st.floats(-3.0, 3.0), st.floats(0.5, 2.0), st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)))
def test_a_shape_that_is_turned_scaled_and_moved_keeps_its_form(
    start: FloatArray, rotation: float, scale: float, shift: tuple[float, float]
) -> None:
    center = area_centroid(start)
    arms = start - center
    target = center + np.array(shift) + scale * arms @ turn(rotation)

    middle = Morph(start, target, rotation).at(0.5)

    size = ((1.0 + scale**2) / 2.0) ** 0.5
    expected = Polygon(center + np.array(shift) / 2.0 + size * arms @ turn(rotation / 2.0))
    assert Polygon(middle).symmetric_difference(expected).area < 1e-6 * expected.area


def turn(angle: float) -> FloatArray:
    """Return the matrix that turns rows of points."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


kinds = st.lists(st.sampled_from(THESIS_TYPES), min_size=1, max_size=6)
ticks = st.sampled_from([0, 1, 7, 200, 2**32 - 1])
tasks = st.sampled_from(Task)


@st.composite
def moving_plans(draw: st.DrawFn, shapes: st.SearchStrategy[FloatArray]) -> Plan:
    """Plans with a motion of any kind; goals are anywhere."""
    task, roster = draw(tasks), Roster.of(draw(kinds))
    knots = draw(st.integers(2, 9))
    types = roster.interleaved_types()
    places = st.sampled_from([-90.0, -1.27, -0.01, 0.0, 0.01, 1.28, 2.5, 70.0])
    told = knots if task is Task.GOALS else 1
    track = draw(arrays(np.float64, (told, roster.size, 2), elements=places))
    motion = Motion(draw(ticks), draw(ticks.filter(bool)), draw(shapes), draw(st.floats(-9.0, 9.0)), track, knots)
    if not task.has_goals:
        motion = Motion(motion.begins, motion.ticks, motion.start, motion.rotation_rad, np.empty((0, 0, 2)), knots)
        track, types = np.empty((1, 0, 2)), types[:0]
    method = draw(st.sampled_from(Method)) if task is Task.PARTITION else None
    return Plan(
        *(3, draw(shapes), (), track[-1], types, 0, task),
        roster=None if task is Task.GOALS else roster,
        method=method,
        motion=motion,
        follows=draw(ticks),
    )


@given(moving_plans(contours()))
def test_a_motion_comes_back_as_it_was_sent(plan: Plan) -> None:
    data = encode_body(plan)
    heard = decode_body(data)

    assert isinstance(heard, Plan)
    assert heard.motion is not None
    assert plan.motion is not None
    assert encode_body(heard) == data
    assert np.abs(heard.motion.start - plan.motion.start).max() < 1e-9
    assert heard.motion.track.shape == plan.motion.track.shape
    assert np.abs(heard.motion.track - plan.motion.track).max(initial=0.0) < 1e-9
    assert (heard.follows, heard.motion.begins, heard.motion.ticks) == (
        *(plan.follows, plan.motion.begins),
        plan.motion.ticks,
    )


@given(moving_plans(contours()), st.integers(0, 10_000), st.integers(0, 255))
def test_a_damaged_motion_never_does_more_than_raise_a_frame_error(plan: Plan, place: int, value: int) -> None:
    data = bytearray(encode_body(plan))
    data[place % len(data)] = value
    try:
        heard = decode_body(bytes(data))
    except FrameError as error:
        assert "\n" not in str(error)  # noqa: PT017 - not raising is fine as well
        return
    assert encode_body(heard)


SQUARE = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]])
hostile = st.sampled_from([SQUARE, SQUARE[::-1], SQUARE[[0, 2, 1, 3]], SQUARE * 0.01, SQUARE + 3.0, SQUARE[:2]])


@settings(max_examples=25)
@given(moving_plans(hostile))
def test_a_motion_that_is_none_is_refused_and_all_others_can_be_followed(plan: Plan) -> None:
    try:
        whole = completed(plan, PartitionConfig())
    except ShapeError as error:
        assert "\n" not in str(error)  # noqa: PT017 - not raising is fine as well
        return
    motion = whole.motion
    assert motion is not None
    for share in (0.0, 0.3, 0.99, 1.0):
        tick = motion.begins + share * motion.ticks
        assert np.isfinite(contour_at(whole, tick)).all()
        assert goals_at(whole, tick).shape == goal_rates_at(whole, tick).shape == whole.goals.shape
