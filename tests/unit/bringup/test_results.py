from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tick_builders import PERIOD, make_plan, make_tick

from bringup.engine import TickRecord
from bringup.layout import sensor_carriers
from bringup.resolution import resolve
from bringup.results import WARM_UP_S, FormationMetrics, Outcome, Timing, formation_metrics
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario, parse_assignment
from bringup.supervisor import Supervisor
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.messages.report import Positioning
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


def test_without_goals_the_places_where_robots_ended_stand_for_them(smoke: Scenario) -> None:
    nowhere = replace(make_plan([]), task=Task.FORCES)
    metrics = metrics_of(smoke, drive({0: nowhere}))

    assert metrics.displacement_lower_bound_m == pytest.approx(16.0)
    assert metrics.displacement_ratio == pytest.approx(1.0, rel=0.02)
    assert metrics.goals_reached == 4  # robots inside


def test_without_goals_only_who_lives_is_in_the_bound(smoke: Scenario) -> None:
    metrics = metrics_of(smoke, drive({0: replace(make_plan([]), task=Task.FORCES)}, dies_at=40))

    assert metrics.displacement_lower_bound_m == pytest.approx(12.0)
    assert metrics.displacement_ratio == pytest.approx(1.0, rel=0.02)
    assert metrics.goals_reached == 3


# Errors of the two robots without position sensor, and of the two beacons.
EARLY_M, BEACON_M = 7.0, 5.0
HEARD_M, LOST_M = 0.3, 2.0
WARM_UP, COUNTED = round(WARM_UP_S / PERIOD), 180  # ticks


def localization_metrics(ticks: int, lost_last: int, early_s: float = WARM_UP_S) -> FormationMetrics:
    """Return the metrics of a run in which the robots without sensor err by known amounts.

    One of them hears three beacons, is localized and off by `HEARD_M`; the other hears one, and in the last
    `lost_last` ticks is lost and off by `LOST_M` instead of `HEARD_M`. Before `early_s` both are off by `EARLY_M`;
    beacons always are off by `BEACON_M`.
    """
    scenario = resolve(*load_scenario("smoke-4", (parse_assignment("position_sensor_share=0.5"),)))
    carriers = sensor_carriers(scenario)
    heard, other = sorted(set(range(4)) - carriers)
    records = []
    for tick in range(ticks):
        record = make_tick(tick, STARTS.tolist())
        reports = dict(record.reports)
        for robot, report in reports.items():
            is_lost = robot == other and tick >= ticks - lost_last
            error = BEACON_M if robot in carriers else LOST_M if is_lost else HEARD_M
            if robot not in carriers and tick * PERIOD < early_s:
                error = EARLY_M
            state = Positioning.LOST if is_lost else Positioning.LOCALIZED
            reports[robot] = replace(
                report,
                position=report.position + np.array([0.0, error]),
                beacons=3 if robot == heard else 1,
                localization=replace(report.localization, positioning=state),
            )
        records.append(replace(record, reports=reports))
    return metrics_of(scenario, records)


def test_localization_counts_robots_without_sensor_after_the_warm_up() -> None:
    lost = 10
    metrics = localization_metrics(WARM_UP + COUNTED, lost)
    samples = 2 * COUNTED

    rms = np.sqrt((lost * LOST_M**2 + (samples - lost) * HEARD_M**2) / samples)
    assert metrics.localization_rmse_m == pytest.approx(rms)
    assert metrics.localization_max_m == pytest.approx(LOST_M)
    # Ten of 360 samples are large: more than one in a hundred, fewer than five.
    assert metrics.localization_p99_m == pytest.approx(LOST_M)
    # Of unit covariance, NEES is the squared error: 0.09 and 4 both lie in the 95 % band.
    assert metrics.localization_consistent == pytest.approx(1.0)


def test_localization_is_told_apart_by_who_hears_beacons_and_who_is_lost() -> None:
    metrics = localization_metrics(WARM_UP + COUNTED, 10)

    assert metrics.localization_rmse_heard_m == pytest.approx(HEARD_M)
    assert metrics.localization_rmse_lost_m == pytest.approx(LOST_M)


def test_of_a_short_run_the_second_half_counts() -> None:
    metrics = localization_metrics(WARM_UP, 10, early_s=0.5 * WARM_UP_S)

    assert metrics.localization_rmse_m == pytest.approx(np.sqrt((10 * LOST_M**2 + 110 * HEARD_M**2) / 120))


def test_an_estimate_far_outside_its_covariance_is_not_consistent() -> None:
    metrics = localization_metrics(WARM_UP, 0)

    assert metrics.localization_rmse_lost_m is None
    assert metrics.localization_consistent == 0.0  # 49 is beyond the band


def test_where_all_carry_a_sensor_all_count_from_the_start(smoke: Scenario) -> None:
    record = make_tick(0, STARTS.tolist())
    off = np.array([0.0, 0.5])
    reports = {robot: replace(report, position=report.position + off) for robot, report in record.reports.items()}

    assert metrics_of(smoke, [replace(record, reports=reports)]).localization_rmse_m == pytest.approx(0.5)
