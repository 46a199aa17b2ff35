from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, Point, Polygon

from mission_computer.membership import Member
from mission_computer.plan_making import DOUBT_MAX_M, SIGMAS, PlanMaker, body_outline, nearest_inside
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import ConfigError, FrameError, ShapeError
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.plan_goals import completed, goals_crc
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, NodeId

SQUARE = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]])
WALL = np.array([[10.0, 0.0], [11.0, 0.0], [11.0, 3.0]])
SMALL, LARGE = THESIS_TYPES[0], THESIS_TYPES[2]
ROSTER = Roster.of([SMALL] * 6 + [LARGE] * 3)


def make_maker(**changes: object) -> PlanMaker:
    settings: dict[str, object] = {"roster": ROSTER, "obstacles": (WALL,), "bounds": None} | changes
    return PlanMaker(PartitionConfig(), **settings)  # type: ignore[arg-type]


@pytest.fixture
def maker() -> PlanMaker:
    return make_maker()


@pytest.fixture
def first(maker: PlanMaker) -> Plan:
    return maker.for_shape(1, SQUARE, ())


def dead(robot: int, position: FloatArray | None, goal: int = -1, robot_type: int = 1, epoch: int = 1) -> Member:
    where = None if position is None else (float(position[0]), float(position[1]))
    return Member(NodeId(robot), robot_type, where, epoch, goal, 0.0)


def same_rows(plan: Plan, first: Plan) -> list[int]:
    """Return the goals of the first plan that are goals of `plan` too."""
    return [row for row, goal in enumerate(first.goals) if (plan.goals == goal).all(axis=1).any()]


def goals_of(plan: Plan, number: int) -> list[int]:
    return np.flatnonzero(plan.goal_types == number).tolist()


def body_gaps(plan: Plan, body: FloatArray) -> list[float]:
    radii = ROSTER.radii_of(plan.goal_types)
    return [Polygon(body).distance(Point(p)) - r for p, r in zip(plan.goals, radii, strict=True)]


def test_a_robot_lost_at_its_goal_takes_only_that_goal_with_it(maker: PlanMaker, first: Plan) -> None:
    goal = goals_of(first, 1)[2]

    plan = maker.for_members(2, [dead(7, first.goals[goal], goal)])

    kept = [row for row in range(9) if row != goal]
    assert plan.epoch == 2
    np.testing.assert_array_equal(plan.goals, first.goals[kept])
    np.testing.assert_array_equal(plan.goal_types, first.goal_types[kept])


def test_a_robot_lost_on_the_way_frees_the_goal_that_it_was_driving_to(maker: PlanMaker, first: Plan) -> None:
    goal = goals_of(first, 1)[3]

    plan = maker.for_members(2, [dead(7, np.array([-20.0, 0.0]), goal)])

    assert same_rows(plan, first) == [row for row in range(9) if row != goal]


def test_a_body_on_a_goal_of_its_type_costs_that_goal_rather_than_the_one_it_was_driving_to(
    maker: PlanMaker, first: Plan
) -> None:
    own, under = goals_of(first, 1)[:2]

    plan = maker.for_members(2, [dead(7, first.goals[under], own)])

    assert same_rows(plan, first) == [row for row in range(9) if row != under]


def test_a_body_on_a_goal_of_another_type_moves_that_goal_aside(maker: PlanMaker, first: Plan) -> None:
    own, under = goals_of(first, 1)[0], goals_of(first, 3)[0]

    plan = maker.for_members(2, [dead(7, first.goals[under], own)])

    body = plan.obstacles[-1]
    assert sorted(plan.goal_types) == [1] * 5 + [3] * 3
    assert min(body_gaps(plan, body)) >= PartitionConfig().gaps.obstacle_m - 1e-6
    moved = [row for row in range(9) if row not in (*same_rows(plan, first), own)]
    assert under in moved
    assert len(moved) <= 4


def test_bodies_are_obstacles_of_the_plan_beside_those_of_the_map(maker: PlanMaker, first: Plan) -> None:
    plan = maker.for_members(2, [dead(7, np.array([4.0, 4.0])), dead(8, None)])

    assert len(plan.obstacles) == 2
    np.testing.assert_array_equal(plan.obstacles[0], first.obstacles[0])
    np.testing.assert_array_equal(plan.obstacles[1], body_outline((4.0, 4.0), SMALL.coverage_radius_m))
    assert (first.bodies, plan.bodies) == (0, 1)
    assert len(plan.goals) == 7


def test_the_outline_of_a_body_is_as_wide_as_its_place_is_uncertain(maker: PlanMaker) -> None:
    maker.for_shape(1, SQUARE, ())
    there = np.array([4.0, 4.0])
    widths = [
        float(np.ptp(maker.for_members(2, [replace(dead(7, there), sigma=sigma)]).obstacles[-1][:, 0]))
        for sigma in (0.0, 0.2, 5.0)
    ]

    assert widths[1] - widths[0] == pytest.approx(2 * SIGMAS * 0.2, abs=0.03)
    assert widths[2] - widths[0] == pytest.approx(2 * DOUBT_MAX_M, abs=0.03)


def test_when_all_are_back_the_first_goals_are_in_force_again(maker: PlanMaker, first: Plan) -> None:
    maker.for_members(2, [dead(7, first.goals[4], 4, int(first.goal_types[4]))])

    plan = maker.for_members(3, ())

    np.testing.assert_array_equal(plan.goals, first.goals)
    assert len(plan.obstacles) == 1


def test_goals_of_an_earlier_epoch_are_still_known_after_renumbering(maker: PlanMaker, first: Plan) -> None:
    small = goals_of(first, 1)
    second = maker.renumbered(maker.for_members(2, [dead(7, None, small[0])]), 5)
    taken = int(np.flatnonzero((second.goals == first.goals[small[4]]).all(axis=1))[0])

    plan = maker.for_members(6, [dead(7, None, small[0]), dead(8, None, taken, epoch=5)])

    assert same_rows(plan, first) == [row for row in range(9) if row not in (small[0], small[4])]


def test_a_shape_ordered_after_losses_is_filled_with_those_who_are_left(maker: PlanMaker) -> None:
    maker.for_shape(1, SQUARE, ())

    plan = maker.for_shape(2, SQUARE + 1.0, [dead(7, np.array([5.0, 5.0]), robot_type=3)])

    assert sorted(plan.goal_types) == [1] * 6 + [3] * 2
    assert min(body_gaps(plan, plan.obstacles[-1])) >= PartitionConfig().gaps.obstacle_m - 1e-6


def test_who_returns_after_such_an_order_gets_a_goal_too(maker: PlanMaker) -> None:
    maker.for_shape(1, SQUARE, [dead(7, None)])

    assert len(maker.for_members(2, ()).goals) == 9


def test_bodies_that_leave_too_little_room_are_an_error_and_change_nothing() -> None:
    tight = np.array([[0.0, 0.0], [4.2, 0.0], [4.2, 2.0], [0.0, 2.0]])
    maker = make_maker(roster=Roster.of([LARGE] * 3), obstacles=())
    first = maker.for_shape(1, tight, ())

    with pytest.raises(ShapeError, match="obstacles in or beside the shape leave too little room"):
        maker.for_members(2, [dead(7, np.array([1.4, 1.0]), robot_type=3)])

    # In so tight a shape goals rounded to a micrometer are pushed apart by less than that; plans say centimeters.
    np.testing.assert_allclose(maker.for_members(3, ()).goals, first.goals, rtol=0.0, atol=1e-6)


def test_a_plan_that_no_packet_can_hold_is_an_error_and_changes_nothing(maker: PlanMaker, first: Plan) -> None:
    with pytest.raises(FrameError):
        maker.for_shape(2**40, SQUARE + 20.0, ())

    np.testing.assert_array_equal(maker.for_members(2, ()).goals, first.goals)


def test_nobody_left_is_an_error(maker: PlanMaker) -> None:
    maker.for_shape(1, SQUARE, ())
    everybody = [dead(k, None) for k in range(6)] + [dead(6 + k, None, robot_type=3) for k in range(3)]

    with pytest.raises(ConfigError, match="no robot is left"):
        maker.for_members(2, everybody)


def test_more_losses_than_robots_of_a_type_take_no_others(maker: PlanMaker) -> None:
    maker.for_shape(1, SQUARE, ())

    plan = maker.for_members(2, [dead(k, None, robot_type=3) for k in range(20)])

    assert plan.goal_types.tolist() == [1] * 6


def test_a_shape_outside_the_arena_is_refused() -> None:
    with pytest.raises(ShapeError, match="outside the arena"):
        make_maker(bounds=(-1.0, -1.0, 7.5, 9.0)).for_shape(1, SQUARE, ())


def test_the_outline_of_a_body_just_holds_its_circle() -> None:
    outline = Polygon(body_outline((3.0, -2.0), 0.5))

    assert outline.exterior.is_ccw
    assert outline.buffer(1e-5).contains(Point(3.0, -2.0).buffer(0.5, quad_segs=64))
    assert outline.area < 1.1 * np.pi * 0.25


def test_equal_losses_make_equal_plans() -> None:
    plans = []
    for _ in range(2):
        maker = make_maker()
        first = maker.for_shape(1, SQUARE, ())
        plans.append(maker.for_members(2, [dead(7, first.goals[0] + 0.1, robot_type=3)]))

    np.testing.assert_array_equal(plans[0].goals, plans[1].goals)


def test_the_outline_of_a_body_that_was_on_its_way_covers_the_way() -> None:
    outline = Polygon(body_outline((3.0, -2.0), 0.5, (4.0, -2.0)))

    assert outline.is_valid
    assert outline.exterior.is_ccw
    assert outline.buffer(1e-5).contains(LineString([(3.0, -2.0), (4.0, -2.0)]).buffer(0.5))
    assert outline.area < 1.1 * (np.pi * 0.25 + 1.0)


def test_bodies_of_the_lost_still_hold_their_circles_after_the_plan_has_been_transmitted(maker: PlanMaker) -> None:
    maker.for_shape(1, SQUARE, ())
    places = [np.array([20.0 + 0.1237 * k, -3.0 - 0.0713 * k]) for k in range(6)]

    plan = maker.for_members(2, [dead(k, place) for k, place in enumerate(places)])
    heard = decode_body(encode_body(plan))

    assert isinstance(heard, Plan)
    for place, outline in zip(places, heard.obstacles[1:], strict=True):
        assert Polygon(outline).buffer(1e-6).contains(Point(place).buffer(SMALL.coverage_radius_m, quad_segs=64))


GOALLESS = [task for task in Task if task is not Task.GOALS]


@pytest.mark.parametrize("task", GOALLESS)
def test_plans_that_leave_the_goals_to_the_robots_say_for_whom_and_what_to_do(task: Task) -> None:
    plan = make_maker(task=task).for_shape(1, SQUARE, ())

    assert (plan.task, plan.roster, plan.robot_count) == (task, ROSTER, 9)
    assert len(plan.goals) == (9 if task is Task.PARTITION else 0)
    assert plan.method is (Method.BUBBLE_PACKING if task is Task.PARTITION else None)


def test_the_checksum_is_that_of_the_goals_which_robots_find() -> None:
    maker = make_maker(task=Task.PARTITION)
    plan = maker.for_shape(1, SQUARE, ())

    heard = decode_body(encode_body(plan))
    assert isinstance(heard, Plan)
    found = completed(heard, PartitionConfig())

    assert heard.goals_crc == goals_crc(found.goals, found.goal_types) != 0
    np.testing.assert_array_equal(found.goals, plan.goals)
    np.testing.assert_array_equal(maker.as_held(encode_body(plan)).goals, plan.goals)


@pytest.mark.parametrize("task", GOALLESS)
def test_after_a_loss_such_plans_are_for_those_left_and_around_the_body(task: Task) -> None:
    maker = make_maker(task=task)
    maker.for_shape(1, SQUARE, ())

    plan = maker.for_members(2, [dead(7, np.array([4.0, 4.0]), robot_type=3)])

    assert (plan.epoch, plan.bodies, plan.robot_count) == (2, 1, 8)
    assert plan.roster == ROSTER.without([3])
    assert all(gap > 0.0 for gap in body_gaps(plan, plan.body_outlines[0]))
    again = maker.for_members(3, ())
    assert (again.bodies, again.robot_count) == (0, 9)
    np.testing.assert_array_equal(again.goals, maker.for_shape(4, SQUARE, ()).goals)


@pytest.mark.parametrize("task", GOALLESS)
def test_another_number_for_such_a_plan_changes_nothing_else(task: Task) -> None:
    maker = make_maker(task=task)
    plan = maker.for_shape(1, SQUARE, ())

    again = maker.as_held(encode_body(maker.renumbered(plan, 7)))

    assert (again.epoch, again.goals_crc) == (7, plan.goals_crc)
    np.testing.assert_array_equal(again.goals, plan.goals)


def test_a_shape_too_small_to_partition_is_refused_but_forces_may_try() -> None:
    small = 0.2 * SQUARE
    with pytest.raises(ShapeError, match="scale it by at least"):
        make_maker(task=Task.PARTITION).for_shape(1, small, ())

    assert make_maker(task=Task.FORCES).for_shape(1, small, ()).robot_count == 9


@pytest.mark.parametrize("task", GOALLESS)
def test_a_shape_over_an_obstacle_is_refused_whatever_is_asked(task: Task) -> None:
    with pytest.raises(ShapeError, match="obstacle 1"):
        make_maker(task=task).for_shape(1, SQUARE + np.array([3.0, -2.0]), ())


def test_who_is_driven_into_a_shape_goes_to_its_nearest_point() -> None:
    outside = nearest_inside(SQUARE, (-3.0, 2.0))

    assert outside is not None
    np.testing.assert_allclose(outside, [0.0, 2.0])
    assert nearest_inside(SQUARE, (4.0, 4.0)) is None
