"""A robot without any radio neighbor must drive around a wall, and is wrong about where the wall ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bringup import compose
from bringup.compose import ScenarioActors
from bringup.engine import TickRecord
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario import MapSpec, Scenario, StartSpec
from bringup.scenario_file import Origin, load_scenario, parse_assignment
from mission_computer.shape.arena import Obstacle
from swarm_msgs_py.messages.sensing import PositionFix

WALL = Obstacle(name="wall", vertices_m=((-20.0, 1.0), (5.0, 1.0), (5.0, 1.4), (-20.0, 1.4)))
START, GOAL, TOO_FAR_EAST = (1.0, -1.5), (1.0, 4.0), 1.0  # the goal is behind the wall, its end 4 m to the east [m]
PAST_ITS_END, FAR_TOO_FAR_EAST = (7.0, 4.0), 6.0  # a goal to which the way looks free from there [m]
TICKS = 70  # twice as many as the way takes at full speed
SETTINGS = ("backend=massdamper", "shape.scale=1.5", "robots.position_sensor_share=0.0")


def behind_a_wall(goal: tuple[float, float] = GOAL, **lps: float | None) -> Scenario:
    scenario = load_scenario("smoke-4", tuple(map(parse_assignment, SETTINGS)))[0]
    robots, agent = scenario.robots, scenario.agent
    return resolve(
        replace(
            scenario,
            map=MapSpec(bounds_m=(-25.0, -10.0, 15.0, 12.0), obstacles=(WALL,)),
            shape=replace(scenario.shape, translation_m=goal),
            robots=replace(
                robots, types=(replace(robots.types[0], count=1),), start=StartSpec(positions_m=(START,))
            ),
            agent=replace(agent, lps=replace(agent.lps, **lps)),
        ),
        Origin("test"),
    )  # fmt: skip


def drive(
    scenario: Scenario,
    monkeypatch: pytest.MonkeyPatch,
    east: float = TOO_FAR_EAST,
    sigma: float = 0.8,
    ticks: int = TICKS,
) -> list[TickRecord]:
    told = PositionFix(np.add(START, (east, 0.0)), sigma)
    monkeypatch.setattr(compose, "told_start", lambda *_: told)
    records = []
    with InProcessEngine(ScenarioActors(scenario)) as engine:
        for record in engine.ticks():
            records.append(record)
            if record.tick == ticks:
                return records
    raise AssertionError("the engine ended by itself")


def error(record: TickRecord) -> float:
    """Return the error of the estimate [m]; the truth of its time is at the beginning of the tick's motion."""
    (report,) = record.reports.values()
    return float(np.hypot(*(report.position - record.truth.samples[0][0])))


def test_a_wall_that_it_sees_face_to_face_tells_a_robot_that_it_is_not_past_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    records = drive(behind_a_wall(), monkeypatch)

    assert all(record.truth.overlaps == () for record in records)
    assert np.hypot(*(records[-1].truth.samples[-1][0] - GOAL)) < 0.3
    assert error(records[0]) == pytest.approx(TOO_FAR_EAST, abs=0.01)
    assert error(records[-1]) < 0.2


def test_without_walls_as_landmarks_it_stands_before_the_wall_and_believes_to_be_past_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    records = drive(behind_a_wall(wall_sigma_m=None), monkeypatch)

    assert all(record.truth.overlaps == () for record in records)
    assert records[-1].truth.samples[-1][0, 1] < 1.0  # south of the wall, as at the start
    assert records[-1].truth.samples[-1][0, 0] < 5.0
    (report,) = records[-1].reports.values()
    assert report.position[0] > 5.0


@pytest.mark.parametrize("is_doubting", [True, False], ids=["with doubt", "without"])
def test_a_robot_that_is_sure_to_be_past_the_end_and_gets_nowhere_doubts_that_and_gets_round(
    is_doubting: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No wall within three standard deviations explains what stands in its way: only doubt makes it look farther."""
    scenario = behind_a_wall(PAST_ITS_END, **({} if is_doubting else {"doubt_m2_per_s": 0.0}))

    records = drive(scenario, monkeypatch, FAR_TOO_FAR_EAST, 0.4, ticks=120)

    assert all(record.truth.overlaps == () for record in records)
    assert (records[-1].truth.samples[-1][0, 1] > 1.4) == is_doubting
    assert (error(records[-1]) < 0.6 * FAR_TOO_FAR_EAST) == is_doubting
