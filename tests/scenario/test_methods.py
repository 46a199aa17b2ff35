"""Every method forms a shape, with and without the mission computer, and among lost robots."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from run_folders import metrics_of, run_in_process

from bringup.compose import ScenarioActors
from bringup.formation_kind import METHODS
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario, method_overrides, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from swarm_agent.agent import Agent
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.types import MISSION, NodeId

SMALL = ("smoke-4", "shape.scale=3", "duration_s=120", "backend=massdamper")
DEMO = ("demo", "backend=massdamper", "duration_s=150")


@dataclass(frozen=True, eq=False)
class Watched(ScenarioActors):
    """Actors of a scenario whose agents can be looked into."""

    agents: dict[NodeId, Agent] = field(default_factory=dict)

    def agent(self, robot: NodeId) -> Agent:
        self.agents[robot] = ScenarioActors.agent(self, robot)
        return self.agents[robot]


def formed(method: str, base: tuple[str, ...], *settings: str) -> tuple[Verdict | None, Supervisor, Watched]:
    """Run a scenario to its verdict."""
    name, *some = base
    overrides = (*method_overrides(method), *map(parse_assignment, (*some, *settings)))
    scenario: Scenario = resolve(*load_scenario(name, overrides))
    actors, verdict = Watched(scenario), None
    supervisor = Supervisor(actors.robots, scenario.success, scenario.sim.period_s, scenario.duration_s)
    with InProcessEngine(actors) as engine:
        for record in engine.ticks():
            verdict = supervisor.watch(record)
            if verdict is not None:
                break
    return verdict, supervisor, actors


def plans_of(actors: Watched) -> dict[NodeId, Plan]:
    return {robot: agent.plan for robot, agent in actors.agents.items() if agent.plan is not None}


@pytest.mark.parametrize("method", METHODS)
def test_every_method_forms_a_small_shape(method: str, tmp_path: Path) -> None:
    out = tmp_path / "run"
    name, *settings = SMALL
    options = [word for setting in settings for word in ("--set", setting)]

    assert run_in_process(out, "--scenario", name, "--method", method, *options) == 0

    metrics = metrics_of(out)
    assert (metrics["method"], metrics["achieved"], metrics["collisions"]) == (method, True, 0)
    assert (metrics["goals_reached"], metrics["inside_fraction"]) == (4, 1.0)
    assert metrics["displacement_ratio"] >= 1.0 - 1e-6
    with np.load(out / "trajectories.npz") as arrays:
        assert len(arrays["goals"]) == (0 if method.startswith("forces") else 4)


@pytest.mark.parametrize("seed", [1, 3])
def test_twelve_robots_under_forces_fill_a_shape_among_obstacles(seed: int) -> None:
    verdict, supervisor, _ = formed("forces", DEMO, f"seed={seed}")

    assert verdict is not None
    assert verdict.achieved, verdict.reason
    assert verdict.reason.startswith("shape formed: 12 of 12 robots inside the shape, at rest since")
    assert supervisor.plan is not None
    assert supervisor.plan.task is Task.FORCES


@pytest.mark.parametrize("method", ["voronoi", "forces"])
def test_the_shape_is_formed_though_the_mission_computer_is_off_as_soon_as_it_was_told(method: str) -> None:
    several_hops = "sim.radio.range_m=9"
    verdict, supervisor, actors = formed(method, DEMO, "events=[{at_s: 2.0, stop: mission_computer}]", several_hops)

    assert verdict is not None
    assert verdict.achieved, verdict.reason
    plans = plans_of(actors)
    assert len(plans) == 12
    assert supervisor.plan is not None
    assert {plan.epoch for plan in plans.values()} == {1}
    assert {plan.goals.tobytes() for plan in plans.values()} == {supervisor.plan.goals.tobytes()}
    assert supervisor.plan.task is (Task.PARTITION if method == "voronoi" else Task.FORCES)


def test_what_happens_is_the_same_whoever_computes_the_goals() -> None:
    runs = [formed("voronoi", SMALL, f"mission.task={task}") for task in ("goals", "partition")]

    assert len({str(verdict) for verdict, _, _ in runs}) == 1
    assert len({supervisor.plan.goals.tobytes() for _, supervisor, _ in runs if supervisor.plan is not None}) == 1


@pytest.mark.parametrize("method", ["voronoi", "forces"])
def test_after_losses_the_others_form_the_shape_around_the_bodies(method: str) -> None:
    events = "events=[{at_s: 8.0, kill: [3, 9]}]"
    patience = ("lost_after_s=4", "regroup_pause_s=2", "hold_s=12", "sim.radio.loss=0.0")
    verdict, supervisor, actors = formed(method, DEMO, events, *patience)

    assert verdict is not None
    assert verdict.achieved, verdict.reason
    plan = supervisor.plan
    assert plan is not None
    assert (plan.robot_count, plan.bodies) == (10, 2)
    alive = {robot: its for robot, its in plans_of(actors).items() if robot not in {3, 9}}
    assert {its.epoch for its in alive.values()} == {plan.epoch}
    assert {its.goals.tobytes() for its in alive.values()} == {plan.goals.tobytes()}
    assert len(plan.goals) == (10 if method == "voronoi" else 0)


def test_a_mission_computer_that_is_off_says_and_hears_nothing() -> None:
    scenario = resolve(
        *load_scenario("smoke-4", tuple(map(parse_assignment, (
            "backend=massdamper", "events=[{at_s: 2.0, stop: mission_computer}]"
        ))))
    )  # fmt: skip
    with InProcessEngine(ScenarioActors(scenario)) as engine:
        records = [record for record, _ in zip(engine.ticks(), range(8), strict=False)]

    assert [record.mission is None for record in records] == [False] * 4 + [True] * 4
    assert [MISSION in record.lost for record in records] == [False] * 4 + [True] * 4
    assert records[4].alerts == ("mission computer is switched off, as the scenario says",)
    assert all(record.truth.alive.all() for record in records)
    hellos = [MISSION in report.neighbors for record in records for report in record.reports.values()]
    assert any(hellos)
