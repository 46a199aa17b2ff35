"""What a robot makes of goals that move: whose they are, where they are, and how it drives along."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, make_plan
from deciding import goal_seeking
from numpy.testing import assert_allclose, assert_array_equal

from swarm_agent.control.config import ControlConfig
from swarm_agent.control.path_follower import PathFollower
from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.path_costs import PathCosts
from swarm_agent.decision.rows import RowBook
from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import VERSION_LEAP_MAX, CostRow, Motion, Plan
from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.plan_motion import goals_at, outline_at
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import FloatArray, NodeId

ME, OTHER = NodeId(1), NodeId(2)
GOALS = np.array([[1.0, 0.0], [3.0, 0.0]])
BEGINS, TICKS = 20, 40
NORTH = np.array([0.0, 8.0])
CONTROL = ControlConfig()
RADIUS = 0.3
OPEN = planner_for((), RADIUS, PlanningConfig())


def moving(epoch: int, follows: int, begins: int = BEGINS, by: FloatArray = NORTH, start: FloatArray = GOALS) -> Plan:
    """Return a plan whose goals all move evenly by so much."""
    still = make_plan(start + by, epoch=epoch)
    track = np.linspace(start, start + by, 5)
    motion = Motion(begins, TICKS, still.contour - by, 0.0, track, len(track))
    return replace(still, motion=motion, follows=follows)


def row(robot: NodeId, epoch: int, costs: list[int], version: int = 1) -> CostRow:
    return CostRow(epoch, robot, 1, version, np.array(costs))


def book_with_rows() -> RowBook:
    book = RowBook()
    book.adopt(make_plan(GOALS))
    book.put(row(ME, 1, [100, 300]))
    book.put(row(OTHER, 1, [200, 100], version=4))
    return book


def test_rows_hold_for_a_plan_that_follows_theirs() -> None:
    book = book_with_rows()
    before = book.versions(), book.digest

    assert book.adopt(moving(2, follows=1))

    assert (book.versions(), book.digest) == before
    assert {held.epoch for held in book.offers} == {2}
    assert (book.epoch, book.since) == (2, 1)


def test_they_hold_though_a_plan_in_between_was_never_heard() -> None:
    book = book_with_rows()
    book.adopt(moving(2, follows=1))

    assert book.adopt(moving(7, follows=1))
    assert len(book) == 2


@pytest.mark.parametrize("plan", [moving(2, follows=0), make_plan(GOALS, epoch=2), moving(9, follows=8)])
def test_any_other_plan_begins_without_rows(plan: Plan) -> None:
    book = book_with_rows()
    book.adopt(plan)

    assert (len(book), book.digest, book.since) == (0, 0, plan.epoch)


def test_a_plan_with_goals_for_others_does_not_inherit_rows_whatever_it_says() -> None:
    book = book_with_rows()
    book.adopt(replace(moving(2, follows=1), goal_types=np.array([1, 2])))

    assert len(book) == 0


def test_rows_under_the_number_of_a_plan_that_was_followed_count_and_those_before_do_not() -> None:
    book = RowBook()
    book.adopt(make_plan(GOALS, epoch=3))
    book.adopt(moving(5, follows=3))

    assert [book.put(row(ME, epoch, [1, 2], version)) for version, epoch in enumerate((2, 3, 4, 5), 1)] == [
        False, True, True, True,
    ]  # fmt: skip
    assert book.version_of(ME) == 4


def test_own_rows_are_counted_on_through_plans_that_follow_each_other() -> None:
    mesh = MeshNetwork(ME, NetworkConfig(), PERIOD)
    mesh.receive(0, ())
    consensus = Consensus(ME, 1, DecisionConfig(), PERIOD)
    consensus.receive(0, [Delivery(OTHER, encode_body(make_plan(GOALS)))], mesh)
    consensus.offer(0, np.array([100, 300]), mesh)
    consensus.receive(1, [Delivery(OTHER, encode_body(moving(2, follows=1)))], mesh)

    # Rows of its own may lead the count of its offers by so much: one from an earlier life of the robot.
    consensus.receive(2, [Delivery(OTHER, encode_body(row(ME, 2, [1, 2], VERSION_LEAP_MAX + 1)))], mesh)

    assert consensus.book.epoch == 2
    assert consensus.book.version_of(ME) == VERSION_LEAP_MAX + 1


class Mind:
    """The decision of robot 1, without a body; another robot has the first goal."""

    def __init__(self) -> None:
        self.consensus, self.strategy = goal_seeking(ME, DecisionConfig(), PERIOD)
        self.consensus.book.adopt(make_plan(GOALS))
        self.consensus.book.put(row(OTHER, 1, [100, 900]))
        for tick in range(2):
            decision = self.strategy.step(tick, GOALS[1])
        assert decision.goal == 1


def test_a_robot_keeps_its_goal_and_offers_nothing_when_it_moves_on() -> None:
    mind = Mind()
    mind.consensus.book.adopt(moving(2, follows=1))

    decisions = {tick: mind.strategy.step(tick, GOALS[1]) for tick in range(2, 70)}

    assert {decision.goal for decision in decisions.values()} == {1}
    assert mind.consensus.book.version_of(ME) == 1
    still = [tick for tick, decision in decisions.items() if decision.drift is None]
    assert still == [tick for tick in decisions if not BEGINS <= tick < BEGINS + TICKS]
    assert_array_equal(decisions[BEGINS].destination, GOALS[1])
    halfway = decisions[BEGINS + TICKS // 2]
    assert_allclose(halfway.destination, GOALS[1] + 0.5 * NORTH)
    assert halfway.drift is not None
    ahead = decisions[BEGINS + TICKS // 2 + 1].destination
    assert ahead is not None
    assert_allclose(halfway.destination + PERIOD * halfway.drift, ahead)
    assert_array_equal(decisions[69].destination, GOALS[1] + NORTH)


def test_until_a_motion_begins_the_one_before_it_goes_on() -> None:
    mind = Mind()
    mind.consensus.book.adopt(moving(2, follows=1))
    mind.strategy.step(2, GOALS[1])
    turn = BEGINS + TICKS // 2
    mind.consensus.book.adopt(moving(3, follows=1, begins=turn, by=-NORTH, start=GOALS + 0.5 * NORTH))

    places = [mind.strategy.step(tick, GOALS[1]).destination for tick in (BEGINS, turn - 1, turn, turn + TICKS)]

    assert places[1] is not None
    assert_array_equal(places[0], GOALS[1])
    assert 3.0 < places[1][1] < 4.0
    assert_allclose(places[2], GOALS[1] + 0.5 * NORTH)
    assert_allclose(places[3], GOALS[1] - 0.5 * NORTH)


def shared_out_anew(moves: Plan, tick: int) -> Plan:
    """Return a plan whose motion begins where that of another one is by then, with goals of its own."""
    anew = moving(3, follows=0, begins=tick, start=goals_at(moves, tick))
    assert anew.motion is not None
    motion = replace(anew.motion, start=outline_at(moves, tick))
    return replace(anew, contour=anew.contour + 1.0, motion=motion)


def test_while_goals_are_shared_out_anew_it_follows_the_one_that_it_had() -> None:
    mind, moves = Mind(), moving(2, follows=1)
    mind.consensus.book.adopt(moves)
    mind.strategy.step(2, GOALS[1])
    mind.consensus.book.adopt(shared_out_anew(moves, BEGINS + 20))

    decision = mind.strategy.step(BEGINS + 10, GOALS[1])

    assert (decision.goal, decision.mode) == (-1, Mode.UNASSIGNED)
    assert decision.destination is not None
    assert GOALS[1][1] < decision.destination[1] < GOALS[1][1] + 0.5 * NORTH[1]
    assert decision.drift is not None


def test_who_has_missed_a_plan_does_not_wait_at_a_goal_of_the_shape_before_it() -> None:
    mind, missed = Mind(), moving(2, follows=1, by=5.0 * NORTH)
    missed = replace(missed, contour=missed.contour + 5.0 * NORTH)
    mind.strategy.step(2, GOALS[1])
    mind.consensus.book.adopt(shared_out_anew(missed, BEGINS + TICKS))

    decision = mind.strategy.step(BEGINS + TICKS, GOALS[1])

    assert decision.goal == -1
    assert decision.destination is not None
    assert_allclose(decision.destination, GOALS[1] + 5.0 * NORTH, atol=2.1)


@pytest.mark.parametrize("earlier", [[100, 800], [101, 800], [102, 800], [103, 800]])
def test_after_a_restart_under_a_plan_that_follows_a_robot_outbids_what_it_said_before(earlier: list[int]) -> None:
    mind = Mind()  # which has sent one row
    mesh = MeshNetwork(ME, NetworkConfig(), PERIOD)
    mesh.receive(0, ())
    mind.consensus.book.adopt(moving(2, follows=1))
    mind.strategy.step(2, GOALS[1])

    mind.consensus.receive(3, [Delivery(OTHER, encode_body(row(ME, 1, earlier)))], mesh)
    mind.strategy.step(3, GOALS[1])

    assert mind.consensus.book.version_of(ME) == 2


def test_goals_that_move_cost_what_it_takes_to_where_they_are() -> None:
    paths = PathCosts(THESIS_TYPES[0], PlanningConfig())
    plan = moving(2, follows=1)

    costs = [paths.of(tick, plan, GOALS[0]).tolist() for tick in (0, BEGINS + TICKS // 2, BEGINS + TICKS)]

    assert costs == [[0, 200], [400, 447], [800, 825]]


def follow(follower: PathFollower, speed: float, seconds: float, position: FloatArray) -> list[FloatArray]:
    """Drive after a goal that moves east; return the offsets from it."""
    goal, drift, offsets = np.zeros(2), np.array([speed, 0.0]), []
    for _ in range(round(seconds / PERIOD)):
        velocity = follower.step(OPEN, position, goal, drift=drift)
        position, goal = position + PERIOD * velocity, goal + PERIOD * drift
        offsets.append(position - goal)
    return offsets


def test_a_robot_follows_a_moving_goal_without_lag() -> None:
    follower = PathFollower(CONTROL, PERIOD, RADIUS)

    offsets = follow(follower, 0.3, 10.0, np.array([0.0, 0.1]))

    assert_allclose(offsets[-1], [0.0, 0.0], atol=1e-3)
    assert not follower.is_parked


def test_no_robot_is_told_to_drive_faster_than_it_may() -> None:
    velocity = PathFollower(CONTROL, PERIOD, RADIUS).step(OPEN, np.zeros(2), np.array([2.0, 1.0]), drift=np.ones(2))

    assert np.hypot(*velocity) == pytest.approx(CONTROL.speed_max_m_s)


def test_a_goal_that_hardly_moves_wakes_nobody_until_it_has_gone_away() -> None:
    follower = PathFollower(CONTROL, PERIOD, RADIUS)
    follower.step(OPEN, np.zeros(2), np.zeros(2))
    assert follower.is_parked

    offsets = follow(follower, 0.5 * CONTROL.park_drift_m_s, 60.0, np.zeros(2))

    farthest = max(float(np.hypot(*offset)) for offset in offsets)
    assert 0.9 * CONTROL.unpark_m < farthest < 1.2 * CONTROL.unpark_m


def test_a_parked_robot_goes_along_from_the_first_tick_and_parks_again_at_the_end() -> None:
    follower = PathFollower(CONTROL, PERIOD, RADIUS)
    follower.step(OPEN, np.zeros(2), np.zeros(2))
    drift = np.array([0.1, 0.0])

    assert_allclose(follower.step(OPEN, np.zeros(2), np.zeros(2), drift=drift), drift)
    assert not follower.is_parked
    assert_array_equal(follower.step(OPEN, PERIOD * drift, PERIOD * drift), [0.0, 0.0])
    assert follower.is_parked


def test_around_an_obstacle_it_drives_at_full_speed_to_where_the_goal_is_by_now() -> None:
    wall = np.array([[4.0, -3.0], [5.0, -3.0], [5.0, 3.0], [4.0, 3.0]])
    planner, follower = planner_for((wall,), RADIUS, PlanningConfig()), PathFollower(CONTROL, PERIOD, RADIUS)
    drift = np.array([0.0, 0.2])

    velocities = [follower.step(planner, np.zeros(2), np.array([9.0, 0.1 * tick]), drift=drift) for tick in range(4)]

    assert_allclose([np.hypot(*velocity) for velocity in velocities], CONTROL.speed_max_m_s)
    assert len(follower.path) > 1
    assert_allclose(follower.path[-1], [9.0, 0.3])


def test_another_goal_is_no_goal_that_moves() -> None:
    follower = PathFollower(CONTROL, PERIOD, RADIUS)
    follower.step(OPEN, np.zeros(2), np.zeros(2))

    velocity = follower.step(OPEN, np.zeros(2), np.array([5.0, 0.0]), drift=np.array([0.0, 0.01]))

    assert not follower.is_parked
    assert_allclose(velocity, [CONTROL.speed_max_m_s, 0.0])
