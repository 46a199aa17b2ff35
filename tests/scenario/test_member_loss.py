"""Robots die during a run: the rest re-form around the bodies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bringup.compose import ScenarioActors
from bringup.engine import TickRecord
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario import Scenario, StartSpec
from bringup.scenario_file import Origin, load_scenario, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.simulation import Simulation

SETTINGS = ("backend=massdamper", "duration_s=120", "shape.scale=3.2")
SQUATTER, TRAVELER = NodeId(5), NodeId(6)
EARLY, LATER = 1, 10  # ticks after which the two die; all have been heard by then, and nobody has got far


class FatalEngine(InProcessEngine):
    """The real engine, in which given robots die at given ticks."""

    def __init__(self, scenario: Scenario, deaths: dict[int, NodeId], monkeypatch: pytest.MonkeyPatch) -> None:
        super().__init__(ScenarioActors(scenario))
        self._deaths = deaths
        self._worlds: list[Simulation] = []
        make = ScenarioActors.simulation
        monkeypatch.setattr(ScenarioActors, "simulation", lambda actors: self._keep(make(actors)))

    def _keep(self, world: Simulation) -> Simulation:
        self._worlds.append(world)
        return world

    def ticks(self) -> Iterator[TickRecord]:
        for record in super().ticks():
            if record.tick in self._deaths:
                self._worlds[-1].kill(self._deaths[record.tick])
            yield record


def square_swarm() -> Scenario:
    """Five small robots along the lower edge of the yard and three middle ones along the upper."""
    scenario = load_scenario("smoke-4", tuple(map(parse_assignment, SETTINGS)))[0]
    small, middle = replace(scenario.robots.types[0], count=5), replace(scenario.robots.types[0], type=2, count=3)
    return replace(scenario, robots=replace(scenario.robots, types=(small, middle)))


def first_plan(scenario: Scenario) -> Plan:
    with InProcessEngine(ScenarioActors(resolve(scenario, Origin("test")))) as engine:
        plan = next(engine.ticks()).plan
    assert plan is not None
    return plan


def with_squatter(scenario: Scenario) -> Scenario:
    """Start the squatter, a middle robot, on a goal that only a small robot can take."""
    plan = first_plan(scenario)
    contested = plan.goals[plan.goal_types == 1][0]
    starts = [(x, -4.4) for x in (-4.0, -2.0, 0.0, 2.0, 4.0)] + [tuple(contested)] + [(-3.0, 4.2), (0.0, 4.2)]
    points = tuple((float(x), float(y)) for x, y in starts)
    return replace(scenario, robots=replace(scenario.robots, start=StartSpec(positions_m=points)))


def outcome(scenario: Scenario, engine: InProcessEngine) -> tuple[list[TickRecord], Verdict]:
    robots = tuple(NodeId(k) for k in range(scenario.robots.count))
    supervisor = Supervisor(robots, scenario.success, scenario.sim.period_s, scenario.duration_s)
    records = []
    with engine:
        for record in engine.ticks():
            records.append(record)
            verdict = supervisor.watch(record)
            if verdict is not None:
                return records, verdict
    raise AssertionError("the engine ended by itself")


@pytest.fixture(scope="module")
def run() -> Iterator[tuple[list[TickRecord], Verdict]]:
    scenario = resolve(with_squatter(square_swarm()), Origin("test"))
    with pytest.MonkeyPatch.context() as monkeypatch:
        yield outcome(scenario, FatalEngine(scenario, {EARLY: SQUATTER, LATER: TRAVELER}, monkeypatch))


def live_distances(records: list[TickRecord], plan: Plan) -> FloatArray:
    last = records[-1]
    rows = sorted(last.reports)
    goals = plan.goals[[last.reports[robot].goal for robot in rows]]
    distances: FloatArray = np.linalg.norm(last.truth.samples[-1][rows] - goals, axis=1)
    return distances


def test_a_body_on_a_goal_and_a_loss_on_the_way_do_not_keep_the_rest_from_their_goals(
    run: tuple[list[TickRecord], Verdict],
) -> None:
    records, verdict = run
    plans = [record.plan for record in records if record.plan is not None]

    assert verdict.achieved, verdict.reason
    assert len(plans[-1].goals) == 6
    assert sorted(records[-1].reports[robot].goal for robot in records[-1].reports) == list(range(6))
    assert live_distances(records, plans[-1]).max() <= 0.25


def test_nobody_touches_a_body_on_the_way(run: tuple[list[TickRecord], Verdict]) -> None:
    records, _ = run

    assert all(record.truth.overlaps == () for record in records)
    assert min(record.truth.min_clearance for record in records) > 0.0


def test_the_operator_reads_of_each_loss_in_one_line(run: tuple[list[TickRecord], Verdict]) -> None:
    records, _ = run

    assert [alert for record in records for alert in record.alerts] == [
        "r05 is lost; new plan for 7 robots",
        "r06 is lost; new plan for 6 robots",
    ]
    assert [record.plan.epoch for record in records if record.plan is not None] == [1, 2, 3]
