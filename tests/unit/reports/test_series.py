from __future__ import annotations

import numpy as np
import pytest
from recorded_runs import PERIOD, made_run, run_in_space, run_on_lattice

from reports.run_record import RunRecord
from reports.series import Chart, charts, goal_distances, links_by_tick


def chart_of(record: RunRecord, name: str) -> Chart:
    return next(chart for chart in charts(record) if chart.name == name)


def line_of(record: RunRecord, name: str, label: str) -> np.ndarray:
    return next(line.values for line in chart_of(record, name).lines if line.label == label)


def test_goal_distances_shrink_to_nothing_and_leave_out_the_dead() -> None:
    record = made_run(ticks=20)
    distances = goal_distances(record)
    ways = np.linalg.norm(record.arrays["position"][0] - record.arrays["goals_points"], axis=-1)

    assert distances[0] == pytest.approx(ways)
    assert distances[19, :-1] == pytest.approx(ways[:-1] / 20)
    assert np.isnan(distances[10:, -1]).all()
    assert line_of(record, "goal-distance", "largest")[0] == pytest.approx(ways.max())


def test_a_goal_that_the_plan_does_not_have_is_no_distance() -> None:
    record = made_run(goal=np.full((20, 6), 6))

    assert np.isnan(goal_distances(record)).all()


def test_localization_errors_are_those_of_robots_without_sensor() -> None:
    record = made_run()
    at_ticks = record.edge_positions[:-1]
    off = np.zeros_like(at_ticks)
    off[:, 1, 0], off[:, 2, 0] = 100.0, 3.0  # robot 1 carries a sensor
    record = made_run(estimate=at_ticks + off)

    assert line_of(record, "localization", "largest") == pytest.approx(3.0)
    assert line_of(record, "localization", "rms")[0] == pytest.approx(3.0 / np.sqrt(5))
    assert line_of(record, "localization", "rms as the robots believe") == pytest.approx(np.sqrt(0.5))


def test_modes_count_the_living_and_beside_them_the_lost_and_those_that_are_off() -> None:
    record = made_run(ticks=20)

    assert line_of(record, "modes", "traveling")[[0, 12, 19]].tolist() == [6.0, 5.0, 0.0]
    assert line_of(record, "modes", "parked")[19] == 5.0
    assert line_of(record, "modes", "lost")[:6].tolist() == [0.0, 1.0, 1.0, 1.0, 1.0, 0.0]
    assert line_of(record, "modes", "off")[[9, 10]].tolist() == [0.0, 1.0]


def test_displacement_adds_up_to_the_ways_that_were_driven() -> None:
    record = made_run(ticks=20)
    ways = np.linalg.norm(record.arrays["position"][-1] - record.arrays["position"][0], axis=-1).sum()

    chart = chart_of(record, "displacement")
    assert chart.times[-1] == pytest.approx(20 * PERIOD)
    assert chart.lines[0].values[[0, -1]] == pytest.approx([0.0, ways])


def test_links_come_and_go_as_recorded() -> None:
    linked = [links.copy() for links in links_by_tick(made_run(robots=6, ticks=20))]

    assert np.argwhere(np.triu(linked[0])).tolist() == [[0, 1], [1, 2], [2, 6]]
    assert np.argwhere(np.triu(linked[9])).tolist() == [[0, 1], [1, 2], [2, 6]]
    assert np.argwhere(np.triu(linked[10])).tolist() == [[1, 2], [2, 6]]
    assert (linked[10] == linked[10].T).all()


def test_connectivity_counts_neighbors_and_parts_of_living_radios() -> None:
    record = made_run(robots=6, ticks=20)

    assert line_of(record, "connectivity", "neighbors per radio")[0] == pytest.approx(6 / 7)
    assert line_of(record, "connectivity", "connected parts")[[0, 10]].tolist() == [4.0, 4.0]  # one died, one parted


def test_traffic_is_a_rate() -> None:
    assert line_of(made_run(), "traffic", "all radios") == pytest.approx(1000 * 8 / 1000 / PERIOD)


def test_a_run_shows_the_charts_that_it_has_numbers_for() -> None:
    assert {chart.name for chart in charts(run_in_space())} == {
        *("modes", "displacement", "clearance", "connectivity", "traffic"),
    }


def test_a_structure_grows_by_places_and_docks() -> None:
    run = run_on_lattice()
    filled = np.minimum(1 + np.arange(run.ticks) // 5, 3)
    record = RunRecord(run.metrics, run.scenario, {**run.arrays, "filled": filled})
    chart = next(chart for chart in charts(record) if chart.name == "structure")

    places, docks = (line.values for line in chart.lines)
    assert places.tolist() == filled.tolist()
    assert docks[[0, 4, 5, 11, 12, 19]].tolist() == [0, 0, 1, 1, 2, 2]


def test_what_is_covered_is_shown_when_it_was_looked_at() -> None:
    run = run_in_space()
    more = {"covered_time": np.array([0.5, 3.0]), "covered_share": np.array([0.1, 1.0])}
    chart = charts(RunRecord(run.metrics, run.scenario, {**run.arrays, **more}))[0]

    assert (chart.name, chart.times.tolist()) == ("covered", [0.5, 3.0])
    assert chart.lines[0].values.tolist() == [0.1, 1.0]
