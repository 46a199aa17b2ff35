"""When a robot sends its costs, when it decides, and for what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, make_plan
from deciding import goal_seeking
from numpy.testing import assert_array_equal

from swarm_agent.decision.assignment import assign
from swarm_agent.decision.config import DecisionConfig
from swarm_msgs_py.messages.bodies import UNREACHABLE, CostRow
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import MISSION, FloatArray, IntArray, NodeId

ME = NodeId(1)
ORIGIN = np.zeros(2)
NEAR, FAR = [1.0, 0.0], [3.0, 0.0]
CONFIG = DecisionConfig()
SETTLE = round(CONFIG.settle_s / PERIOD)


class Mind:
    """The decision of robot 1, without a body."""

    def __init__(self) -> None:
        self.consensus, self.strategy = goal_seeking(ME, CONFIG, PERIOD)

    def hear_row(self, robot: int, costs: list[int], version: int = 1) -> None:
        self.consensus.book.put(CostRow(1, NodeId(robot), 1, version, np.array(costs)))

    def step_through(self, first: int, position: FloatArray, seconds: float, takes_part: bool = True) -> list[int]:
        """Step for a while; return the versions of the own row after each step."""
        versions = []
        for tick in range(first, first + round(seconds / PERIOD) + 1):
            self.strategy.step(tick, position, takes_part)
            versions.append(self.own_version)
        return versions

    @property
    def own_version(self) -> int:
        return self.consensus.book.version_of(ME)

    @property
    def own_costs(self) -> IntArray:
        (row,) = (row for row in self.consensus.book.missing_in(()) if row.robot == ME)
        return row.costs


def with_two_goals() -> Mind:
    mind = Mind()
    mind.consensus.book.adopt(make_plan(np.array([NEAR, FAR])))
    return mind


def test_between_its_goals_it_waits_for_all_rows_of_its_type() -> None:
    mind = with_two_goals()

    decision = mind.strategy.step(0, np.array([2.0, 0.0]))

    assert decision.mode is Mode.UNASSIGNED
    assert decision.destination is None
    assert mind.own_version == 1


def test_decides_as_soon_as_the_rows_are_complete() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [50, 400])  # the near goal is worth more to the other: 50 + 300 < 100 + 400

    decision = mind.strategy.step(1, ORIGIN)

    assert decision.goal == 1
    assert_array_equal(decision.destination, FAR)


def test_patience_ends() -> None:
    mind = with_two_goals()
    ticks = round(CONFIG.patience_s / PERIOD)

    decisions = [mind.strategy.step(tick, ORIGIN) for tick in range(ticks + 1)]

    assert [d.goal for d in decisions] == [-1] * ticks + [0]


def test_far_from_the_shape_it_sets_out_before_the_rows_are_complete() -> None:
    mind = with_two_goals()

    decision = mind.strategy.step(0, np.array([40.0, 0.0]))

    assert decision.goal == -1
    assert decision.destination is not None


def test_a_new_plan_for_the_same_shape_leaves_it_on_its_way_and_one_for_another_shape_does_not() -> None:
    mind = with_two_goals()
    mind.hear_row(2, [0, 500])
    mind.strategy.step(0, ORIGIN)
    plan = mind.consensus.plan
    assert plan is not None

    mind.consensus.book.adopt(replace(plan, epoch=2))
    same = mind.strategy.step(1, ORIGIN)
    mind.consensus.book.adopt(replace(plan, epoch=3, contour=plan.contour + 50.0, goals=plan.goals + 50.0))
    other = mind.strategy.step(2, ORIGIN)

    assert same.destination is not None
    assert_array_equal(same.destination, FAR)
    assert other.destination is not None
    assert other.destination.min() >= 50.0


def test_a_late_row_changes_the_decision() -> None:
    mind = with_two_goals()
    for tick in range(round(CONFIG.patience_s / PERIOD) + 1):
        mind.strategy.step(tick, ORIGIN)
    mind.hear_row(2, [50, 400])

    assert [mind.strategy.step(100 + tick, ORIGIN).goal for tick in range(SETTLE + 1)] == [0] * SETTLE + [1]


def test_a_burst_of_rows_that_ends_where_it_began_moves_nobody() -> None:
    mind = with_two_goals()
    for tick in range(round(CONFIG.patience_s / PERIOD) + 1):
        mind.strategy.step(tick, ORIGIN)
    mind.hear_row(2, [50, 400])
    during = mind.strategy.step(100, ORIGIN)
    mind.hear_row(2, [500, 100], version=2)

    after = [mind.strategy.step(101 + tick, ORIGIN).goal for tick in range(2 * SETTLE)]

    assert [during.goal, *after] == [0] * (1 + 2 * SETTLE)


def test_who_has_moved_sends_a_fresh_row_for_a_newcomer() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    moved = np.array([CONFIG.refresh_distance_m + 0.5, 0.0])
    mind.hear_row(2, [50, 400])

    mind.step_through(1, moved, CONFIG.refresh_pause_s + CONFIG.refresh_spread_s)

    assert mind.own_version == 2


def test_many_newcomers_cost_one_fresh_row() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    for newcomer in range(2, 9):
        mind.hear_row(newcomer, [50, 400])
        mind.strategy.step(newcomer, np.array([CONFIG.refresh_distance_m + 1.0, 0.0]))
    versions = mind.step_through(9, np.array([CONFIG.refresh_distance_m + 1.0, 0.0]), 20.0)

    assert mind.own_version == 2
    assert versions[0] == 1


def test_a_fresh_row_speaks_for_the_goal_that_the_robot_has() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [500, 100])
    mind.strategy.step(1, ORIGIN)
    mind.hear_row(3, [900, 900])

    mind.step_through(2, np.array([0.0, 3.0]), CONFIG.refresh_pause_s + CONFIG.refresh_spread_s)

    exact = np.hypot([1.0, 3.0], 3.0) * 100 - [CONFIG.keep_goal_m * 100, 0]
    assert_array_equal(mind.own_costs, np.rint(exact))


def test_who_has_not_moved_leaves_its_row_as_it_is() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [50, 400])

    mind.step_through(1, np.array([CONFIG.refresh_distance_m - 0.5, 0.0]), 20.0)

    assert mind.own_version == 1


def test_a_fresh_row_of_a_known_robot_is_no_newcomer() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [50, 400])
    mind.strategy.step(1, ORIGIN)
    mind.hear_row(2, [60, 410], version=2)

    mind.step_through(2, np.array([5.0, 0.0]), 20.0)

    assert mind.own_version == 1


def test_one_robot_too_many_stays_without_a_goal() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, np.array([90.0, 0.0]))
    mind.hear_row(2, [50, 400])
    mind.hear_row(3, [400, 50])

    decision = mind.strategy.step(1, np.array([90.0, 0.0]))

    assert decision.goal == -1
    assert decision.destination is None
    assert decision.mode is Mode.UNASSIGNED


def test_without_a_plan_it_waits_and_then_searches() -> None:
    mind = Mind()

    early = mind.strategy.step(0, np.array([9.0, 9.0]))
    late = mind.strategy.step(round(CONFIG.rally_after_s / PERIOD), np.array([9.0, 9.0]))

    assert early.mode is Mode.WAITING
    assert early.destination is None
    assert late.mode is Mode.SEARCHING
    assert late.destination is not None


def test_a_new_plan_starts_from_fresh_costs() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.consensus.book.adopt(make_plan(np.array([FAR]), epoch=2))

    decision = mind.strategy.step(5, ORIGIN)

    assert decision.goal == 0
    assert mind.consensus.book.epoch == 2
    assert mind.own_version == 1


def test_a_row_of_an_earlier_life_is_replaced_by_a_true_one() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(1, [7, 7], version=5)

    mind.strategy.step(1, ORIGIN)

    assert mind.own_version == 6
    assert_array_equal(mind.own_costs, [100, 300])


def test_an_estimate_inside_a_wall_or_outside_the_arena_still_makes_costs() -> None:
    walls = (np.array([[20.0, -20.0], [21.0, -20.0], [21.0, 20.0], [20.0, 20.0]]),)
    for estimate in (np.array([20.5, 0.0]), np.array([500.0, -900.0])):
        mind = Mind()
        mind.consensus.book.adopt(replace(make_plan(np.array([NEAR, FAR])), obstacles=walls))

        mind.strategy.step(0, estimate)

        assert mind.own_costs.shape == (2,)
        assert (mind.own_costs < UNREACHABLE).all()


def with_goals_taken() -> Mind:
    """Return robot 1 with the far goal, robot 2 having the near one."""
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [50, 400])
    assert mind.strategy.step(1, ORIGIN).goal == 1
    return mind


def test_who_withdraws_has_no_goal_and_says_so_once() -> None:
    mind = with_goals_taken()

    decision = mind.strategy.step(2, ORIGIN, takes_part=False)
    versions = mind.step_through(3, np.array([9.0, 9.0]), 20.0, takes_part=False)

    assert (decision.goal, decision.destination) == (-1, None)
    assert set(versions) == {2}


def test_the_goal_of_who_withdraws_stays_reserved() -> None:
    mind = with_goals_taken()
    mind.strategy.step(2, ORIGIN, takes_part=False)

    taken = assign(mind.consensus.book.of_type(1))

    assert taken == {1: 1, 2: 0}
    assert_array_equal(mind.own_costs, [UNREACHABLE, 300])


def test_who_comes_back_has_its_goal_again_and_nobody_hears_of_it() -> None:
    mind = with_goals_taken()
    mind.strategy.step(2, ORIGIN, takes_part=False)

    decision = mind.strategy.step(3, np.array([1.0, 0.2]))

    assert decision.goal == 1
    assert mind.own_version == 2


def test_who_withdraws_before_it_has_a_goal_offers_an_empty_row_and_costs_when_it_is_back() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN, takes_part=False)
    lengths = [len(mind.own_costs)]

    mind.strategy.step(1, ORIGIN)

    assert [*lengths, len(mind.own_costs)] == [0, 2]
    assert mind.own_version == 2


def test_a_goal_that_another_robot_can_use_is_given_up() -> None:
    mind = with_goals_taken()
    mind.strategy.step(2, ORIGIN, takes_part=False)
    mind.hear_row(3, [300, 300])

    mind.strategy.step(3, ORIGIN, takes_part=False)

    assert len(mind.own_costs) == 0
    assert assign(mind.consensus.book.of_type(1)) == {2: 0, 3: 1}


def test_nobody_waits_for_who_has_withdrawn() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.consensus.book.put(CostRow(1, NodeId(2), 1, 1, np.empty(0, dtype=np.int64)))

    assert mind.strategy.step(1, ORIGIN).goal == 0


def test_who_has_neither_goal_nor_a_route_to_the_mission_computer_goes_to_meet_others() -> None:
    mind = with_two_goals()
    far_off = np.array([90.0, 0.0])
    mind.hear_row(2, [50, 400])
    mind.hear_row(3, [400, 50])
    ticks = round(CONFIG.rally_after_s / PERIOD)

    decisions = [mind.strategy.step(tick, far_off) for tick in range(ticks + 1)]

    assert [d.mode for d in decisions] == [Mode.UNASSIGNED] * ticks + [Mode.SEARCHING]
    assert_array_equal(decisions[-1].destination, np.zeros(2))


def test_who_has_no_goal_but_a_route_to_the_mission_computer_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MeshNetwork, "reachable", (MISSION,))
    mind = with_two_goals()
    mind.hear_row(2, [50, 400])
    mind.hear_row(3, [400, 50])

    modes = {mind.strategy.step(tick, np.array([90.0, 0.0])).mode for tick in range(60)}

    assert modes == {Mode.UNASSIGNED}


def test_who_loses_its_goal_to_a_new_plan_waits_for_a_newer_one_before_it_goes_to_meet_others() -> None:
    mind = Mind()
    mind.consensus.book.adopt(make_plan(np.array([NEAR])))
    ticks = round(CONFIG.rally_after_s / PERIOD)
    assert [mind.strategy.step(tick, ORIGIN).goal for tick in range(5 * ticks)][-1] == 0
    mind.consensus.book.adopt(make_plan(np.array([NEAR]), types=[2], epoch=2))

    modes = [mind.strategy.step(tick, ORIGIN).mode for tick in range(5 * ticks, 6 * ticks + 2)]

    assert modes == [Mode.UNASSIGNED] * ticks + [Mode.SEARCHING] * 2
