"""When a robot sends its costs, when it decides, and for what."""

from __future__ import annotations

import numpy as np
from builders import PERIOD, make_plan
from numpy.testing import assert_array_equal

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.goal_seeking import GoalSeeking
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.messages.bodies import CostRow
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import NodeId

ME = NodeId(1)
ORIGIN = np.zeros(2)
NEAR, FAR = [1.0, 0.0], [3.0, 0.0]
CONFIG = DecisionConfig()


class Mind:
    """The decision of robot 1, without a body."""

    def __init__(self) -> None:
        mesh = MeshNetwork(ME, NetworkConfig(), PERIOD)
        mesh.receive(0, ())
        self.consensus = Consensus(ME, 1, CONFIG, PERIOD)
        self.strategy = GoalSeeking(
            ME,
            THESIS_TYPES[0],
            config=CONFIG,
            planning=PlanningConfig(),
            mesh=mesh,
            consensus=self.consensus,
            obstacles=(),
            period_s=PERIOD,
        )

    def hear_row(self, robot: int, costs: list[int], version: int = 1) -> None:
        self.consensus.book.put(CostRow(1, NodeId(robot), 1, version, np.array(costs)))

    @property
    def own_version(self) -> int:
        return self.consensus.book.version_of(ME)


def with_two_goals() -> Mind:
    mind = Mind()
    mind.consensus.book.adopt(make_plan(np.array([NEAR, FAR])))
    return mind


def test_waits_for_all_rows_of_its_type() -> None:
    mind = with_two_goals()

    decision = mind.strategy.step(0, ORIGIN)

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


def test_a_late_row_changes_the_decision() -> None:
    mind = with_two_goals()
    for tick in range(round(CONFIG.patience_s / PERIOD) + 1):
        mind.strategy.step(tick, ORIGIN)
    mind.hear_row(2, [50, 400])

    assert mind.strategy.step(100, ORIGIN).goal == 1


def test_who_has_moved_sends_a_fresh_row_for_a_newcomer() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    moved = np.array([CONFIG.refresh_distance_m + 0.5, 0.0])
    mind.hear_row(2, [50, 400])

    mind.strategy.step(1, moved)

    assert mind.own_version == 2


def test_who_has_not_moved_leaves_its_row_as_it_is() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [50, 400])

    mind.strategy.step(1, np.array([CONFIG.refresh_distance_m - 0.5, 0.0]))

    assert mind.own_version == 1


def test_a_fresh_row_of_a_known_robot_is_no_newcomer() -> None:
    mind = with_two_goals()
    mind.strategy.step(0, ORIGIN)
    mind.hear_row(2, [50, 400])
    mind.strategy.step(1, ORIGIN)
    mind.hear_row(2, [60, 410], version=2)

    mind.strategy.step(2, np.array([5.0, 0.0]))

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
