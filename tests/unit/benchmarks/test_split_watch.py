from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from robustness_watch import SplitWatch
from tick_builders import make_plan, make_report, make_tick

from bringup.compose import ScenarioActors
from bringup.resolution import resolve
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import FloatArray, NodeId

FAR = 500.0  # from the mission computer: four robots out there are a part of their own
GOALS = np.array([[FAR, -20.0 + 4.0 * row] for row in range(4)])
PLAN = make_plan(GOALS.tolist())
TICKS = 40


@pytest.fixture(scope="module")
def smoke() -> Scenario:
    return resolve(*load_scenario("smoke-4"))


def busy(scenario: Scenario, place: Callable[[int], FloatArray], mode: Mode, goals: range | list[int]) -> float:
    """Return the share of busy robots in the part without the mission computer."""
    watch = SplitWatch(scenario, ScenarioActors(scenario).scene)
    for tick in range(TICKS):
        points = place(tick).tolist()
        record = make_tick(tick, points, plan=PLAN if tick == 0 else None)
        reports = {NodeId(robot): make_report(points[robot], goal, mode) for robot, goal in enumerate(goals)}
        watch.take(replace(record, reports=reports))
    share = watch.summary()["busy_without_computer"]
    assert isinstance(share, float)
    return share


def test_a_robot_that_drives_toward_its_goal_is_busy(smoke: Scenario) -> None:
    assert busy(smoke, lambda tick: GOALS - [40.0 - 0.2 * tick, 0.0], Mode.TRAVELING, range(4)) == 1.0


def test_a_robot_that_stands_with_a_goal_is_not_busy(smoke: Scenario) -> None:
    assert busy(smoke, lambda _: GOALS - [40.0, 0.0], Mode.TRAVELING, range(4)) == 0.0


def test_a_robot_that_drives_away_from_its_goal_is_not_busy(smoke: Scenario) -> None:
    assert busy(smoke, lambda tick: GOALS - [40.0 + 0.2 * tick, 0.0], Mode.TRAVELING, range(4)) == 0.0


def test_a_robot_that_creeps_is_not_busy(smoke: Scenario) -> None:
    assert busy(smoke, lambda tick: GOALS - [40.0 - 0.01 * tick, 0.0], Mode.TRAVELING, range(4)) == 0.0


def test_a_robot_that_drives_without_a_goal_is_not_busy(smoke: Scenario) -> None:
    assert busy(smoke, lambda tick: GOALS - [40.0 - 0.2 * tick, 0.0], Mode.UNASSIGNED, [0, 1, -1, -1]) == 0.5


def test_a_robot_that_is_parked_at_its_goal_is_busy_and_elsewhere_not(smoke: Scenario) -> None:
    off = np.array([[0.0, 0.0], [0.2, 0.0], [0.0, 0.3], [2.0, 0.0]])  # the tolerance is a quarter of a meter

    assert busy(smoke, lambda _: GOALS + off, Mode.PARKED, range(4)) == 0.5


def test_a_robot_that_goes_round_an_obstacle_is_busy_while_its_goal_gets_farther(smoke: Scenario) -> None:
    # A wall between start and goal; the end that is nearer on the way lies away from the goal.
    wall = replace(smoke.map.obstacles[0], vertices_m=((0.0, -145.0), (1.0, -145.0), (1.0, 10.0), (0.0, 10.0)))
    arena = replace(smoke.map, bounds_m=(-150.0, -150.0, 150.0, 150.0), obstacles=(wall,))
    mission = replace(smoke.mission, position_m=(-140.0, 140.0))
    walled = replace(smoke, map=arena, mission=mission)
    goals = np.array([[20.0, -80.0 - 4.0 * row] for row in range(4)])
    plan = make_plan(goals.tolist())
    watch = SplitWatch(walled, ScenarioActors(walled).scene)
    for tick in range(TICKS):
        points = [[-4.0 - 4.0 * row, -40.0 + 0.2 * tick] for row in range(4)]
        record = make_tick(tick, points, plan=plan if tick == 0 else None)
        reports = {NodeId(row): make_report(points[row], row, Mode.TRAVELING) for row in range(4)}
        watch.take(replace(record, reports=reports))

    assert watch.summary()["busy_without_computer"] == 1.0
