from __future__ import annotations

import numpy as np
import pytest
from tick_builders import PERIOD, make_plan, make_tick

from bringup.engine import TickRecord
from bringup.resolution import resolve
from bringup.results import FormationMetrics, Outcome, Timing, formation_metrics
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario
from bringup.supervisor import Supervisor
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.trace import TraceRecorder

STARTS = np.array([[-3.0, -3.0], [-1.0, -3.0], [1.0, -3.0], [3.0, -3.0]])
GOALS = STARTS + np.array([0.0, 4.0])
FULL, LATE = make_plan(GOALS.tolist()), make_plan(GOALS[:3].tolist())
TICKS = 80


@pytest.fixture(scope="module")
def smoke() -> Scenario:
    return resolve(*load_scenario("smoke-4"))


def metrics_of(scenario: Scenario, records: list[TickRecord]) -> FormationMetrics:
    robots = tuple(NodeId(robot) for robot in range(4))
    recorder = TraceRecorder(robots, PERIOD)
    supervisor = Supervisor(robots, scenario.success, PERIOD, 1000.0)
    for record in records:
        recorder.record(record.truth, record.reports)
        supervisor.watch(record)
    verdict = supervisor.unfinished(TICKS * PERIOD)
    return formation_metrics(scenario, "inprocess", Outcome(recorder, supervisor, verdict, Timing(0.0, 1.0)))


def drive(plans: dict[int, Plan], dies_at: int = TICKS) -> list[TickRecord]:
    """Return ticks in which all drive straight to their goals; the last robot dies on its way and stays where it is."""
    records = []
    for tick in range(TICKS):
        points = STARTS + (GOALS - STARTS) * tick / (TICKS - 1)
        points[3] = STARTS[3] + (GOALS - STARTS)[3] * min(tick, dies_at) / (TICKS - 1)
        lost = frozenset({NodeId(3)}) if tick >= dies_at else frozenset()
        records.append(make_tick(tick, points.tolist(), plan=plans.get(tick), lost=lost, speed=0.1))
    return records


def test_straight_ways_to_the_goals_are_the_bound(smoke: Scenario) -> None:
    metrics = metrics_of(smoke, drive({0: FULL}))

    assert metrics.displacement_lower_bound_m == pytest.approx(16.0)
    assert metrics.total_displacement_m == pytest.approx(16.0, rel=0.02)
    assert metrics.displacement_ratio == pytest.approx(1.0, rel=0.02)


def test_a_robot_that_died_on_its_way_is_neither_in_the_bound_nor_in_the_ratio(smoke: Scenario) -> None:
    metrics = metrics_of(smoke, drive({0: FULL, 45: LATE}, dies_at=40))

    assert metrics.displacement_lower_bound_m == pytest.approx(12.0)
    assert metrics.total_displacement_m == pytest.approx(14.0, rel=0.02)  # its two meters were driven, though
    assert metrics.displacement_ratio == pytest.approx(1.0, rel=0.02)


def test_after_a_change_of_shape_there_is_no_bound(smoke: Scenario) -> None:
    other = make_plan(GOALS.tolist(), contour=((-4, -4), (4, -4), (4, 4), (-4, 4)))
    metrics = metrics_of(smoke, drive({0: FULL, 20: other}))

    assert metrics.total_displacement_m > 0.0
    assert metrics.displacement_lower_bound_m is None
    assert metrics.displacement_ratio is None
    assert metrics.bottleneck_time_s is None
