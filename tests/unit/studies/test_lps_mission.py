from __future__ import annotations

from dataclasses import replace

import pytest

from bringup.scenario import Scenario
from bringup.scenario_file import Origin, Override, load_scenario
from studies import lps_mission
from studies.lps_cells import Cell, Experiment, Trial
from swarm_agent.localization.config import LpsMode

ROBOTS, BEACONS = 14, 3  # 15 %, rounded up
DURATION_S, WARM_UP_S, PERIOD_S = 6.0, 2.0, 0.5


def test_a_mission_is_scored_by_its_robots_without_sensor_after_the_warm_up(monkeypatch: pytest.MonkeyPatch) -> None:
    def load_short(source: str, overrides: tuple[Override, ...]) -> tuple[Scenario, Origin]:
        scenario, origin = load_scenario(source, overrides)
        return replace(scenario, duration_s=DURATION_S), origin

    monkeypatch.setattr(lps_mission, "load_scenario", load_short)
    monkeypatch.setattr(lps_mission, "WARM_UP_S", WARM_UP_S)
    cell = Cell(experiment=Experiment.MISSION, mode=LpsMode.COOPERATIVE, period_s=0.0)

    scores = lps_mission.run_mission(cell, 1, Trial(robots=ROBOTS))

    assert scores.samples == (ROBOTS - BEACONS) * round((DURATION_S - WARM_UP_S) / PERIOD_S)
    assert scores.lost_share == 0.0  # by definition: the mission promises errors of the swarm as it is
    assert scores.achieved is False
