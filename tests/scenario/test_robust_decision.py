"""The whole swarm under a bad radio, deaths on the way, and a network that falls apart and merges again.

Few robots carry a position sensor; the others range: what the radio loses, their positions lose too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from bringup.compose import ScenarioActors
from bringup.engine import TickRecord
from bringup.inprocess import InProcessEngine
from bringup.layout import sensor_carriers
from bringup.resolution import resolve
from bringup.scenario_file import ROBOT_COUNT, Override, load_scenario, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.messages.bodies import Plan

ROBOTS, BEACONS = 12, {3, 5, 9}
MASSDAMPER, SHARE = "sim.physics.backend=massdamper", "position_sensor_share=0.25"
Run = tuple[list[TickRecord], Verdict]


def run(name: str, *settings: str) -> Run:
    overrides = [parse_assignment(text) for text in (MASSDAMPER, SHARE, *settings)]
    overrides.append(Override("--agents", ROBOT_COUNT, ROBOTS))
    scenario = resolve(*load_scenario(name, tuple(overrides)))
    assert sensor_carriers(scenario) == BEACONS
    actors = ScenarioActors(scenario)
    supervisor = Supervisor(actors.robots, scenario.success, actors.period_s, scenario.duration_s)
    records = []
    with InProcessEngine(actors) as engine:
        for record in engine.ticks():
            records.append(record)
            verdict = supervisor.watch(record)
            if verdict is not None:
                return records, verdict
    raise AssertionError("the engine ended by itself")


def plans_of(records: Sequence[TickRecord]) -> list[Plan]:
    return [record.plan for record in records if record.plan is not None]


def has_agreed(record: TickRecord, plan: Plan) -> bool:
    """Return whether all live robots hold this plan, as many rows as they are, and goals that are all different."""
    reports = record.reports.values()
    goals = [report.goal for report in reports]
    is_complete = all(report.epoch == plan.epoch and report.rows == len(reports) for report in reports)
    return is_complete and min(goals) >= 0 and len(set(goals)) == len(goals)


def assert_no_collision(records: Sequence[TickRecord]) -> None:
    assert all(record.truth.overlaps == () for record in records)


def test_lost_and_late_frames_cost_little_time_and_no_collision() -> None:
    good, _ = run("demo")
    bad, verdict = run("demo", "radio.loss=0.3", "delay_ticks_max=1")

    assert verdict.achieved, verdict.reason
    assert len(bad) <= 1.3 * len(good)
    assert has_agreed(bad[-1], plans_of(bad)[-1])
    assert_no_collision(bad)


def test_a_fifth_of_the_robots_dies_and_the_rest_form_the_shape_around_them() -> None:
    victims = {1, 4, 9}
    events = "events=[{at_s: 6.5, kill: [9]}, {at_s: 10.0, kill: [4]}, {at_s: 14.0, kill: [1]}]"
    records, verdict = run("demo", events, "lost_after_s=8")
    plans = plans_of(records)

    assert len(victims) >= ROBOTS / 5
    assert victims & BEACONS  # the others lose one of three that tell where they are
    assert verdict.achieved, verdict.reason
    assert [len(plan.goals) for plan in (plans[0], plans[-1])] == [ROBOTS, ROBOTS - len(victims)]
    assert set(records[-1].reports) == set(range(ROBOTS)) - victims
    assert has_agreed(records[-1], plans[-1])
    assert_no_collision(records)


@pytest.fixture(scope="module")
def split() -> Run:
    return run("split-24")


def test_a_network_that_was_in_two_parts_forms_the_shape(split: Run) -> None:
    records, verdict = split

    assert verdict.achieved, verdict.reason
    assert has_agreed(records[-1], plans_of(records)[-1])
    assert_no_collision(records)


def test_the_part_without_the_mission_computer_goes_on_with_the_plan_it_has(split: Run) -> None:
    records, _ = split
    apart = next(record.tick for record in records if record.plan is not None and record.plan.epoch == 2)
    before_merge = records[apart + 20]
    epochs = [report.epoch for report in before_merge.reports.values()]
    speeds = np.linalg.norm(before_merge.truth.velocities, axis=1)

    assert sorted(set(epochs)) == [1, 2]
    assert min(epochs.count(1), epochs.count(2)) >= 3
    assert all(report.goal >= 0 for report in before_merge.reports.values())
    assert (speeds > 0.3).mean() > 0.9


def test_after_the_merge_all_agree_on_one_plan_for_everybody(split: Run) -> None:
    records, _ = split
    plans = plans_of(records)

    assert len(plans[0].goals) == len(plans[-1].goals) == ROBOTS
    assert min(len(plan.goals) for plan in plans) < ROBOTS
    # From the first robot that has heard it: when the plan is made, the mission computer may be out of all range.
    heard = next(record.tick for record in records if any(r.epoch == plans[-1].epoch for r in record.reports.values()))
    agreed = next(record.tick for record in records[heard:] if has_agreed(record, plans[-1]))
    assert (agreed - heard) * 0.5 <= 10.0
