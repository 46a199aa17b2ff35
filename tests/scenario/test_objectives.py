"""A whole swarm under the bottleneck objective, and one whose robots are set to different objectives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bringup.compose import ScenarioActors
from bringup.engine import TickRecord
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario_file import load_scenario, parse_assignment
from bringup.supervisor import Supervisor, Verdict
from swarm_agent.config import AgentConfig
from swarm_msgs_py.messages.bodies import Objective
from swarm_msgs_py.types import FloatArray, NodeId

SETTINGS = ("sim.physics.backend=massdamper", "position_sensor_share=1.0", "known_within_m=0.05")
BOTTLENECK = "agent.decision.objective=bottleneck"


class MixedActors(ScenarioActors):
    """A swarm in which every third robot minimizes the sum, the others the longest path."""

    def agent_config(self, robot: NodeId) -> AgentConfig:
        config = super().agent_config(robot)
        objective = Objective.TOTAL if robot % 3 == 0 else Objective.BOTTLENECK
        return replace(config, decision=replace(config.decision, objective=objective))


def run(*settings: str, actors_of: type[ScenarioActors] = ScenarioActors) -> tuple[list[TickRecord], Verdict]:
    scenario = resolve(*load_scenario("demo", tuple(map(parse_assignment, (*SETTINGS, *settings)))))
    actors = actors_of(scenario)
    supervisor = Supervisor(actors.robots, scenario.success, actors.period_s, scenario.duration_s)
    records = []
    with InProcessEngine(actors) as engine:
        for record in engine.ticks():
            records.append(record)
            verdict = supervisor.watch(record)
            if verdict is not None:
                return records, verdict
    raise AssertionError("the engine ended by itself")


def driven(records: list[TickRecord]) -> FloatArray:
    """Return how far each robot has driven [m]."""
    places = np.concatenate([record.truth.samples for record in records])
    lengths: FloatArray = np.linalg.norm(np.diff(places, axis=0), axis=2).sum(axis=0)
    return lengths


@pytest.fixture(scope="module")
def total() -> tuple[list[TickRecord], Verdict]:
    return run()


@pytest.fixture(scope="module")
def bottleneck() -> tuple[list[TickRecord], Verdict]:
    return run(BOTTLENECK)


def test_for_the_bottleneck_the_longest_way_is_shorter_and_the_swarm_drives_little_more(
    total: tuple[list[TickRecord], Verdict], bottleneck: tuple[list[TickRecord], Verdict]
) -> None:
    assert bottleneck[1].achieved, bottleneck[1].reason
    assert driven(bottleneck[0]).max() < driven(total[0]).max()
    assert driven(bottleneck[0]).sum() <= 1.10 * driven(total[0]).sum()


def test_robots_of_different_settings_do_what_the_majority_wants(
    bottleneck: tuple[list[TickRecord], Verdict],
) -> None:
    records, verdict = run(actors_of=MixedActors)
    goals = {robot: report.goal for robot, report in records[-1].reports.items()}

    assert verdict.achieved, verdict.reason
    assert goals == {robot: report.goal for robot, report in bottleneck[0][-1].reports.items()}
