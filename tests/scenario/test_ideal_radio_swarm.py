"""A swarm with ideal radio does what it does with the mesh, sooner and with less talk."""

from __future__ import annotations

import pytest

from bringup.resolution import resolve
from bringup.results import FormationMetrics, formation_metrics
from bringup.scenario_file import load_scenario, parse_assignment
from studies.headless_mission import ENGINE, run_to_verdict


def metrics_with(model: str) -> FormationMetrics:
    settings = (f"sim.radio.model={model}", "sim.physics.backend=massdamper", "position_sensor_share=1.0")
    scenario = resolve(*load_scenario("smoke-4", tuple(map(parse_assignment, settings))))
    return formation_metrics(scenario, ENGINE, run_to_verdict(scenario))


@pytest.fixture(scope="module")
def ideal() -> FormationMetrics:
    return metrics_with("ideal")


def test_an_ideal_radio_forms_the_shape(ideal: FormationMetrics) -> None:
    assert ideal.achieved
    assert ideal.collisions == 0
    assert ideal.goals_reached == 4


def test_an_ideal_radio_tells_no_routes(ideal: FormationMetrics) -> None:
    mesh = metrics_with("line_of_sight")

    assert mesh.achieved
    # Of a frame per robot and tick at least, the mesh's has rows of routes besides what the ideal one says.
    assert ideal.radio_bytes / ideal.radio_frames < 0.9 * mesh.radio_bytes / mesh.radio_frames
