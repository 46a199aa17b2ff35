from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tick_builders import PERIOD, make_plan, make_report, make_tick

from bringup.engine import TickRecord
from bringup.formation import FormationAccount
from bringup.history import History
from bringup.resolution import resolve
from bringup.scenario_file import load_scenario
from reports.run_record import NEEDED, RunRecord
from reports.series import links_by_tick
from swarm_msgs_py.messages.bodies import Motion
from swarm_msgs_py.messages.report import Mode, Positioning
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import contour_at
from swarm_msgs_py.types import MISSION, NodeId

POINTS = [[0.0, 0.0], [1.0, 0.0]]
SQUARE = ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0))


def heard(record: TickRecord, *neighbors: tuple[int, ...]) -> TickRecord:
    """Return a tick in which the robots have heard these neighbors."""
    reports = {
        NodeId(robot): replace(record.reports[NodeId(robot)], neighbors=tuple(map(NodeId, others)))
        for robot, others in enumerate(neighbors)
    }
    return replace(record, reports=reports)


def recorded(*ticks: TickRecord) -> RunRecord:
    """Return what a history makes of some ticks, as reports see it."""
    history, course = History(), Course()
    for record in ticks:
        if record.plan is not None:
            course.put(record.tick, record.plan)
        history.record(record, course)
    times = np.arange(len(ticks)) * PERIOD
    return RunRecord({}, "", {**history.arrays(), "robot": np.arange(2), "tick_time": times})


def test_a_link_lasts_as_long_as_either_end_hears_the_other() -> None:
    both, one, none = ((1,), (0,)), ((), (0,)), ((), ())
    record = recorded(*(heard(make_tick(tick, POINTS), *who) for tick, who in enumerate([none, both, one, none, both])))

    assert [bool(linked[0, 1]) for linked in links_by_tick(record)] == [False, True, True, False, True]
    assert len(record.arrays["link_tick"]) == 3  # changes only


def test_the_mission_computer_is_a_node_like_others() -> None:
    record = recorded(heard(make_tick(0, POINTS), (MISSION,), ()))

    (linked,) = links_by_tick(record)
    assert np.argwhere(np.triu(linked)).tolist() == [[0, 2]]


def test_paths_are_kept_when_they_change() -> None:
    paths = [np.array([[1.0, 1.0], [2.0, 2.0]])] * 3 + [np.array([[2.0, 2.0]])]
    ticks = []
    for tick, path in enumerate(paths):
        record = make_tick(tick, POINTS)
        ticks.append(replace(record, reports={NodeId(0): replace(make_report([0.0, 0.0], 0), path=path)}))
    kept = recorded(*ticks).paths()[0]

    assert kept.ticks.tolist() == [0, 3]
    assert kept.at(2).tolist() == [[1.0, 1.0], [2.0, 2.0]]
    assert kept.at(3).tolist() == [[2.0, 2.0]]


def test_a_shape_is_kept_once_while_it_rests_and_in_every_tick_while_it_moves() -> None:
    first = make_plan(POINTS, SQUARE)
    shift = np.array([3.0, 0.0])
    moved = np.array(SQUARE) + shift
    goals = np.stack([first.goals, first.goals + shift])
    motion = Motion(begins=4, ticks=3, start=first.contour, rotation_rad=0.0, track=goals, knots=2)
    later = replace(first, epoch=2, contour=moved, goals=goals[-1], motion=motion, follows=1)
    plans = {0: first, 2: later}
    record = recorded(*(make_tick(tick, POINTS, plan=plans.get(tick)) for tick in range(10)))

    shapes = record.point_sets("shape")
    assert shapes.ticks.tolist() == [0, 5, 6, 7]
    assert shapes.at(9) == pytest.approx(moved)
    assert shapes.at(5) == pytest.approx(contour_at(later, 5))
    assert record.point_sets("goals").at(9) == pytest.approx(goals[-1])
    assert record.point_sets("goals").at(4) == pytest.approx(goals[0])


def test_alerts_and_traffic_are_kept_with_their_ticks() -> None:
    quiet, loud = make_tick(0, POINTS), replace(make_tick(1, POINTS, clearance=-0.1), alerts=("r01 died", "again"))
    arrays = recorded(quiet, loud).arrays

    assert arrays["alert_tick"].tolist() == [1, 1]
    assert arrays["alert_text"].tolist() == ["r01 died", "again"]
    assert arrays["radio_bytes"].tolist() == [20, 20]
    assert arrays["clearance"].tolist() == [1.0, -0.1]


def test_a_history_of_nothing_has_all_arrays_and_no_rows() -> None:
    arrays = History().arrays()

    assert {name: len(values) for name, values in arrays.items() if len(values)} == {}
    assert arrays["link_nodes"].shape == (0, 2)
    assert arrays["path_points"].shape == (0, 2)


def test_what_is_stored_of_a_run_is_what_reports_need() -> None:
    scenario = resolve(*load_scenario("smoke-4"))
    account, points = FormationAccount(scenario), [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]
    for tick in range(3):
        account.take(make_tick(tick, points, plan=make_plan(points) if tick == 0 else None))
    arrays = account.arrays()

    assert [name for name in NEEDED if name not in arrays] == []
    assert arrays["mode_names"][Mode.RETURN_HOME] == "return home"
    assert arrays["positioning"].tolist() == [[Positioning.LOCALIZED] * 4] * 3
    assert arrays["carries_sensor"].sum() >= 1
    assert arrays["bounds"].shape == (4,)
    assert arrays["shape_tick"].tolist() == [0]
