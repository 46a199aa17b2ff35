"""Where shape and goals of a plan are at a time."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

from mission_computer.shape import load_shape
from swarm_msgs_py import plan_goals
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.messages.bodies import Motion, Plan, Task
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.plan_goals import completed, is_contour
from swarm_msgs_py.plan_motion import contour_at, goal_rates_at, goals_at, is_moving, outline_at
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster

SQUARE = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]])
AHEAD = SQUARE + np.array([4.0, 0.0])
BEGINS, TICKS = 100, 40
TRACK = np.array([[[1.0, 1.0], [5.0, 5.0]], [[1.0, 1.0], [6.0, 5.0]], [[1.0, 1.0], [9.0, 4.0]],
                  [[1.0, 1.0], [9.0, 6.0]], [[1.0, 1.0], [10.0, 6.0]]])  # fmt: skip
PLAN = Plan(
    *(2, AHEAD, (), TRACK[-1], np.array([1, 1])),
    motion=Motion(BEGINS, TICKS, SQUARE, 0.0, TRACK, len(TRACK)),
    follows=1,
)
STILL = Plan(1, SQUARE, (), TRACK[0], np.array([1, 1]))


@pytest.mark.parametrize(("tick", "knot"), [(0, 0), (100, 0), (110, 1), (120, 2), (130, 3), (140, 4), (999, 4)])
def test_goals_are_at_the_knots_of_the_track_in_time(tick: int, knot: int) -> None:
    assert_allclose(goals_at(PLAN, tick), TRACK[knot], atol=1e-12)


def test_contours_are_those_of_the_plan_before_and_after() -> None:
    assert contour_at(PLAN, 90) is SQUARE
    assert contour_at(PLAN, BEGINS) is SQUARE
    assert contour_at(PLAN, 140) is PLAN.contour
    assert_allclose(contour_at(PLAN, 120).min(axis=0), [2.0, 0.0], atol=1e-9)


def test_an_outline_on_the_way_is_a_contour_in_centimeters_to_begin_another_motion_with() -> None:
    start, target = load_shape("iso_3_rect"), load_shape("iso_4_free")
    nowhere = np.empty((0, 0, 2))
    plan = Plan(2, target, (), nowhere[0:0].reshape(0, 2), np.empty(0, dtype=np.int64), 0, Task.FORCES,
                motion=Motion(0, 400, start, 0.0, nowhere, 8))  # fmt: skip

    for tick in range(1, 400, 7):
        outline, contour = outline_at(plan, tick), contour_at(plan, tick)
        assert is_contour(outline)
        assert_array_equal(outline, outline.round(2))
        assert len(outline) <= len(contour)
        assert shapely.Polygon(outline).symmetric_difference(shapely.Polygon(contour)).area < 1.0
    assert outline_at(plan, 400) is target
    assert outline_at(plan, 0).shape == start.shape


def test_a_plan_without_motion_is_at_rest() -> None:
    assert contour_at(STILL, 7) is SQUARE
    assert goals_at(STILL, 7) is STILL.goals
    assert_array_equal(goal_rates_at(STILL, 7), np.zeros((2, 2)))
    assert not is_moving(STILL, 7)


def test_it_moves_from_its_beginning_until_its_end() -> None:
    assert [is_moving(PLAN, tick) for tick in (99, 100, 139.5, 140)] == [False, True, True, False]


def test_goals_move_with_continuous_velocity_that_begins_and_ends_with_zero() -> None:
    ticks = np.arange(BEGINS - 1.0, BEGINS + TICKS + 1.0, 0.01)
    rates = np.array([goal_rates_at(PLAN, tick) for tick in ticks])

    assert_allclose(rates[[0, -1]], 0.0)
    assert np.abs(np.diff(rates, axis=0)).max() < 0.02 * np.abs(rates).max()


def test_rates_are_the_change_per_tick() -> None:
    for tick in (103.0, 117.0, 125.0, 138.0):
        step = goals_at(PLAN, tick + 1e-4) - goals_at(PLAN, tick - 1e-4)
        assert_allclose(goal_rates_at(PLAN, tick), step / 2e-4, atol=1e-6)


def test_goals_never_leave_the_range_between_two_knots_and_one_at_rest_rests() -> None:
    for tick in np.arange(BEGINS, BEGINS + TICKS, 0.25):
        knot = int((tick - BEGINS) * 4 / TICKS)
        low, high = (bound(TRACK[knot], TRACK[knot + 1]) for bound in (np.minimum, np.maximum))
        goals = goals_at(PLAN, tick)
        assert ((goals >= low - 1e-12) & (goals <= high + 1e-12)).all()
        assert_array_equal(goals[0], TRACK[0, 0])
        assert_array_equal(goal_rates_at(PLAN, tick)[0], [0.0, 0.0])


def turning(rounds: float, task: Task = Task.GOALS, begin: np.ndarray = SQUARE) -> Plan:
    """Return a plan whose goals turn with the shape, about a center that goes 4 m, told at eight knots."""
    turn = 2.0 * np.pi * rounds
    shares = np.linspace(0.0, 1.0, 8)
    track = np.stack([on_the_way(share, turn) for share in shares]).round(2)
    return Plan(2, AHEAD, (), track[-1], np.ones(2, dtype=np.int64), 0, task,
                motion=Motion(BEGINS, TICKS, begin, turn, track, 8))  # fmt: skip


def on_the_way(share: float, turn: float) -> np.ndarray:
    blend = share * share * (3.0 - 2.0 * share)
    cosine, sine = np.cos(blend * turn), np.sin(blend * turn)
    arms = np.array([[3.0, 0.0], [-1.0, 2.0]]) @ np.array([[cosine, sine], [-sine, cosine]])
    return np.array([4.0 + 4.0 * blend, 4.0]) + arms


@pytest.mark.parametrize("rounds", [0.25, -1.0, 2.0])
def test_between_knots_goals_turn_with_the_shape_and_do_not_cut_corners(rounds: float) -> None:
    plan = turning(rounds)

    for tick in np.arange(BEGINS, BEGINS + TICKS, 0.5):
        expected = on_the_way((tick - BEGINS) / TICKS, 2.0 * np.pi * rounds)
        assert_allclose(goals_at(plan, tick), expected, atol=0.02)
    for tick in (103.0, 117.0, 125.0, 138.0):
        step = goals_at(plan, tick + 1e-4) - goals_at(plan, tick - 1e-4)
        assert_allclose(goal_rates_at(plan, tick), step / 2e-4, atol=1e-5)
    assert_allclose(goal_rates_at(plan, BEGINS), 0.0)


@pytest.mark.parametrize("begin", [SQUARE[:0], SQUARE[:2], SQUARE[[0, 2, 1, 3]], SQUARE[::-1], SQUARE * [1.0, 0.0]])
def test_a_forged_contour_yields_goals_all_the_same_and_a_shape_error_for_who_asks_for_it(begin: np.ndarray) -> None:
    plan = turning(1.0, begin=begin)

    assert np.isfinite(goals_at(plan, 110)).all()
    with pytest.raises(ShapeError, match="cross themselves"):
        contour_at(plan, 110)


def test_answers_are_shared_and_cannot_be_written_to() -> None:
    assert contour_at(PLAN, 120) is contour_at(PLAN, 120)
    for answer in (contour_at(PLAN, 120), goals_at(PLAN, 120)):
        with pytest.raises(ValueError, match="read-only"):
            answer[0] = 0.0


ROSTER = Roster.of([THESIS_TYPES[0]] * 6)
START = np.array([[x, y] for x in (1.5, 4.0, 6.5) for y in (2.0, 6.0)])


def order(target: np.ndarray, **changes: object) -> Plan:
    motion = Motion(BEGINS, TICKS, SQUARE, 0.0, START[None], 8)
    fields = {"method": Method.VORONOI, "task": Task.PARTITION, **changes}
    types = np.ones(6, dtype=np.int64)
    return Plan(2, target, (), START, types, roster=ROSTER, motion=motion, **fields)  # type: ignore[arg-type]


def test_robots_find_the_track_and_the_goals_at_its_end() -> None:
    found = completed(order(AHEAD), PartitionConfig())

    assert found.motion is not None
    assert found.motion.track.shape == (8, 6, 2)
    assert_array_equal(found.motion.track[0], START)
    assert_array_equal(found.motion.track[-1], found.goals)
    assert found.motion.track is completed(order(AHEAD), PartitionConfig()).motion.track  # type: ignore[union-attr]
    assert_allclose(found.goals - START, np.tile([4.0, 0.0], (6, 1)), atol=0.5)


def test_until_the_track_is_found_goals_rest_where_they_begin() -> None:
    waiting = order(AHEAD)

    assert_array_equal(goals_at(waiting, 120), START)
    assert_array_equal(goal_rates_at(waiting, 120), np.zeros((6, 2)))


@pytest.mark.parametrize("task", [Task.GOALS, Task.PARTITION, Task.FORCES])
def test_a_motion_to_what_is_no_contour_is_refused_whatever_the_task(task: Task) -> None:
    with pytest.raises(ShapeError, match="cross themselves, run clockwise"):
        completed(order(SQUARE[[0, 2, 1, 3]], task=task), PartitionConfig())


def test_who_is_told_the_goals_does_not_compute_the_contours_between(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan_goals, "morph_between", None)
    plan = turning(0.5)

    assert completed(plan, PartitionConfig()) is plan


def test_a_shape_of_too_many_corners_is_not_moved() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 513, endpoint=False)
    circle = 4.0 + 4.0 * np.column_stack([np.cos(angles), np.sin(angles)])

    with pytest.raises(ShapeError, match="513 corners cannot move; simplify it to 512"):
        completed(order(circle), PartitionConfig())


def test_that_a_plan_cannot_be_followed_is_found_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[int] = []

    def refuse(*_: object, knots: int) -> None:
        tried.append(knots)
        raise ShapeError("no room")

    monkeypatch.setattr(plan_goals, "track", refuse)
    plan = order(SQUARE + 0.77)
    for _ in range(3):
        with pytest.raises(ShapeError, match="no room"):
            completed(plan, PartitionConfig())

    assert tried == [8]


def test_all_who_hold_a_plan_share_the_one_with_its_goals() -> None:
    plan = order(AHEAD)

    assert completed(plan, PartitionConfig()) is completed(plan, PartitionConfig())


def test_fractals_cannot_follow_a_motion() -> None:
    with pytest.raises(ShapeError, match="fractals is not applicable"):
        completed(order(SQUARE + 1.0, method=Method.FRACTALS), PartitionConfig())


def test_a_shape_that_becomes_too_small_is_refused_with_the_place() -> None:
    with pytest.raises(ShapeError, match="% of its motion the shape has no room"):
        completed(order(SQUARE * 0.2), PartitionConfig())
