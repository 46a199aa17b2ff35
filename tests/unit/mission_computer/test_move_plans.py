"""Plans whose shape moves: where they begin, who keeps which goal, and what is refused."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from shapely import Polygon

from mission_computer.membership import Member
from mission_computer.move import Move, haste, rest_of
from mission_computer.plan_making import PlanMaker
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.plan_motion import contour_at, goals_at
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, NodeId

PERIOD = 0.5
SQUARE = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]])
EAST = np.array([12.0, 0.0])
BOUNDS = (-5.0, -5.0, 40.0, 30.0)
WALL = np.array([[11.0, 3.0], [12.0, 3.0], [12.0, 5.0], [11.0, 5.0]])
ROSTER = Roster.of([THESIS_TYPES[0]] * 4 + [THESIS_TYPES[2]] * 2)


def make_maker(task: Task = Task.GOALS, method: Method = Method.BUBBLE_PACKING, *obstacles: FloatArray) -> PlanMaker:
    return PlanMaker(PartitionConfig(method=method), ROSTER, obstacles, BOUNDS, task)


def shifted(begins: int = 10, ticks: int = 40, by: FloatArray = EAST) -> Move:
    return Move(SQUARE + by, begins, ticks, PERIOD)


def dead(plan: Plan, goal: int, epoch: int) -> Member:
    x, y = (float(c) for c in plan.goals[goal])
    return Member(NodeId(9), int(plan.goal_types[goal]), (x, y - 100.0), epoch, goal, 0.0)


def test_a_motion_begins_where_the_plan_before_it_will_be() -> None:
    maker = make_maker()
    first = maker.for_shape(1, SQUARE, ())
    east = maker.for_move(2, shifted(), first, ())
    north = maker.for_move(3, Move(SQUARE + np.array([0.0, 12.0]), 25, 40, PERIOD), east, ())

    assert (east.follows, north.follows) == (1, 1)
    assert east.motion is not None
    assert north.motion is not None
    np.testing.assert_array_equal(east.motion.start, first.contour)
    np.testing.assert_allclose(goals_at(east, 10), first.goals, atol=0.0051)
    begun, there = Polygon(north.motion.start), Polygon(contour_at(east, 25))
    assert begun.symmetric_difference(there).area < 0.01 * there.area
    np.testing.assert_allclose(goals_at(north, 25), goals_at(east, 25), atol=0.0051)
    assert goals_at(north, 25)[:, 0].mean() > first.goals[:, 0].mean() + 3.0  # on its way already
    np.testing.assert_array_equal(north.goal_types, first.goal_types)


@pytest.mark.parametrize("task", [Task.PARTITION, Task.FORCES])
def test_what_robots_find_by_themselves_moves_too(task: Task) -> None:
    maker = make_maker(task, Method.VORONOI)
    plan = maker.for_move(2, shifted(), maker.for_shape(1, SQUARE, ()), ())

    assert plan.motion is not None
    assert len(plan.goals) == (6 if task is Task.PARTITION else 0)
    assert (plan.follows, plan.goals_crc != 0) == ((1, True) if task is Task.PARTITION else (0, False))
    np.testing.assert_allclose(contour_at(plan, 30).mean(axis=0), [10.0, 4.0], atol=0.05)


def test_without_a_lost_robot_its_goal_is_left_out_and_the_others_move_on_from_where_they_are() -> None:
    maker = make_maker()
    east = maker.for_move(2, shifted(), maker.for_shape(1, SQUARE, ()), ())
    lost = 1
    rest = rest_of(east, 30, PERIOD)
    assert rest is not None

    plan = maker.for_move(3, rest, east, [dead(east, lost, epoch=2)])

    kept = [goal for goal in range(6) if goal != lost]
    assert plan.follows == 0
    np.testing.assert_allclose(goals_at(plan, 30), goals_at(east, 30)[kept], atol=0.0051)
    np.testing.assert_array_equal(plan.goal_types, east.goal_types[kept])


def test_after_the_motion_losses_are_dealt_with_as_ever() -> None:
    maker = make_maker()
    east = maker.for_move(2, shifted(), maker.for_shape(1, SQUARE, ()), ())

    plan = maker.for_members(3, [dead(east, 4, epoch=2)])

    assert plan.motion is None
    np.testing.assert_array_equal(plan.goals, np.delete(east.goals, 4, axis=0))


def test_when_a_robot_is_back_there_are_goals_for_all_again() -> None:
    maker = make_maker()
    first = maker.for_shape(1, SQUARE, ())
    fewer = maker.for_members(2, [dead(first, 0, epoch=1)])

    plan = maker.for_move(3, shifted(), fewer, ())

    assert (len(plan.goals), plan.follows) == (6, 0)


def test_robots_share_goals_out_anew_when_another_one_is_lost_than_before_though_they_are_as_many() -> None:
    maker = make_maker()
    maker.for_shape(1, SQUARE, ())
    absent = Member(NodeId(3), 1, (30.0, 20.0), 0, -1, 0.0)
    fewer = maker.for_members(2, [absent])
    gone = int(np.flatnonzero(fewer.goal_types == 1)[0])
    x, y = (float(c) for c in fewer.goals[gone])
    dead_in_place = Member(NodeId(5), 1, (x, y), 2, gone, 0.0)

    same, other = (maker.for_move(3, shifted(), fewer, [lost]) for lost in (absent, dead_in_place))

    assert (same.follows, other.follows) == (2, 0)
    assert len(same.goals) == len(other.goals) == 5
    nearest = float(np.linalg.norm(goals_at(other, 0) - [x, y], axis=1).min())
    assert nearest > 2.0 * THESIS_TYPES[0].coverage_radius_m  # nobody is sent to where the body lies


def test_a_goal_of_a_plan_for_fewer_robots_is_known_by_its_own_number() -> None:
    maker = make_maker()
    first = maker.for_shape(1, SQUARE, ())
    fewer = maker.for_members(2, [dead(first, 0, epoch=1)])
    ghost = Member(NodeId(9), int(first.goal_types[0]), None, 1, 0, 0.0)
    lost = int(np.flatnonzero(fewer.goal_types == 1)[1])

    plan = maker.for_move(3, shifted(), fewer, [ghost, Member(NodeId(8), 1, None, 2, lost, 0.0)])

    np.testing.assert_allclose(goals_at(plan, 0), np.delete(fewer.goals, lost, axis=0), atol=0.0051)


def test_a_forged_number_of_a_plan_takes_no_time_or_memory() -> None:
    maker = make_maker()
    east = maker.for_move(2, shifted(), maker.for_shape(1, SQUARE, ()), ())
    forged = maker.renumbered(east, 40_000_000)
    tracemalloc.start()

    plan = maker.for_move(40_000_001, shifted(60, by=2.0 * EAST), forged, ())
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert plan.follows == 1
    assert peak < 100e6
    np.testing.assert_array_equal(
        maker.for_members(40_000_002, [dead(plan, 4, epoch=40_000_000)]).goals, np.delete(plan.goals, 4, axis=0)
    )


@pytest.mark.parametrize(
    ("obstacles", "by", "words"),
    [
        ((WALL,), EAST, r"after \d+ % of the way: obstacle 1 .*covers"),
        ((), np.array([35.0, 0.0]), "ordered shape: vertex .* outside the arena"),
    ],
)
def test_a_way_that_cannot_be_is_refused(obstacles: tuple[FloatArray, ...], by: FloatArray, words: str) -> None:
    maker = make_maker(Task.GOALS, Method.BUBBLE_PACKING, *obstacles)
    first = maker.for_shape(1, SQUARE, ())

    with pytest.raises(ShapeError, match=words):
        maker.for_move(2, shifted(by=by), first, ())
    assert maker.for_members(2, []).goals.tobytes() == first.goals.tobytes()  # as if nothing had been asked


def test_fractals_do_not_move() -> None:
    maker = make_maker(Task.GOALS, Method.FRACTALS)
    first = maker.for_shape(1, SQUARE, ())

    with pytest.raises(ShapeError, match="fractals is not applicable to moving shapes; use bubble-packing or voronoi"):
        maker.for_move(2, shifted(), first, ())


def test_the_rest_of_a_motion_is_no_faster_than_the_whole() -> None:
    maker = make_maker()
    whole = maker.for_move(2, Move(SQUARE + EAST, 10, 40, PERIOD, np.pi / 2), maker.for_shape(1, SQUARE, ()), ())

    early, late = rest_of(whole, 20, PERIOD), rest_of(whole, 40, PERIOD)

    assert early is not None
    assert late is not None
    assert (early.begins, early.ticks) == (20, 34)  # 84 % of the way in what had been 75 % of the time
    assert early.rotation_rad == pytest.approx(0.84375 * np.pi / 2)
    assert (late.begins, late.ticks) == (40, 10)
    before = rest_of(whole, 5, PERIOD)
    assert before is not None
    assert (before.begins, before.ticks) == (10, 40)
    assert rest_of(whole, 50, PERIOD) is None
    assert rest_of(maker.for_members(3, []), 5, PERIOD) is None


def test_the_operator_reads_when_goals_outrun_the_robots_and_how_long_would_do() -> None:
    maker = make_maker()
    first = maker.for_shape(1, SQUARE, ())
    plan = maker.for_move(2, shifted(ticks=30), first, ())  # 12 m in 15 s, smoothly

    line = haste(plan, PERIOD, 0.5)

    assert line.startswith("goals of plan 2 move at up to 1.")
    seconds = int(line.split()[-2])
    slow = maker.for_move(3, shifted(ticks=2 * seconds), first, ())
    assert haste(slow, PERIOD, 0.5) == haste(first, PERIOD, 0.5) == ""
    assert haste(maker.for_move(4, shifted(ticks=2 * seconds - 6), first, ()), PERIOD, 0.5)
