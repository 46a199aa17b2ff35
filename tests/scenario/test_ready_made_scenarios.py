"""Every ready-made scenario runs as it is written: its first seconds, or through all of its stages and events.

Only robots, room at the start and time are cut short (`SHORTENED`); stages and events stay.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from run_folders import metrics_of
from short_runs import INTERRUPTED, interrupt_after

from bringup.cli import main
from bringup.family import Family
from bringup.scenario_file import load_any, scenario_names

SECONDS = {Family.FORMATION: 6.0, Family.COVERAGE: 14.0, Family.ASSEMBLY: 6.0}
"""Long enough for the first plan to reach the swarm, or for its first robots to visit their ancestors."""
FEW_AND_NEAR = ("--agents", "3", "--set", "half_side_m=12")
SHORTENED = {
    "morph-50": FEW_AND_NEAR,
    "sequence-50": FEW_AND_NEAR,
    "coverage-losses": ("--set", "duration_s=205"),  # the last event is at 200 s
    "coverage-flock": ("--agents", "60", "--set", "duration_s=245"),  # at 240 s
}
"""Scenarios with stages or events, and how they are run through all of these."""
SEEN_ELSEWHERE = {"arena": "test_camera_arena.py goes through its stages"}
ACHIEVED = 0
OPTIONS = {
    Family.FORMATION: ("--physics", "massdamper"),
    Family.COVERAGE: (),
    Family.ASSEMBLY: ("--physics", "massdamper"),
}
BEGINNINGS = [
    (name, family) for family in Family for name in scenario_names(family) if name not in SHORTENED
]  # of the others the beginning is run with the rest


def run(name: str, family: Family, out: Path, *options: str) -> int:
    return main(["--engine", "inprocess", "--out", str(out), "--scenario", name, *OPTIONS[family], *options])


@pytest.mark.parametrize(("name", "family"), BEGINNINGS, ids=str)
def test_a_ready_made_scenario_runs_and_sets_robots_going(
    name: str, family: Family, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt_after(SECONDS[family], monkeypatch)
    code = run(name, family, tmp_path / "run")

    metrics = metrics_of(tmp_path / "run")
    assert code == INTERRUPTED  # nobody is there so soon
    assert metrics["scenario"] == name
    assert metrics["sim_time_s"] == pytest.approx(SECONDS[family], abs=1.1)
    assert metrics["total_displacement_m"] > 0.02 * metrics["robots"]
    if family is Family.FORMATION:
        assert np.isfinite(metrics["localization_rmse_m"])


@pytest.mark.parametrize(("name", "stages"), [("morph-50", 4), ("sequence-50", 3)])
def test_a_ready_made_scenario_goes_through_all_its_stages(name: str, stages: int, tmp_path: Path) -> None:
    code = run(name, Family.FORMATION, tmp_path / "run", *SHORTENED[name])

    metrics = metrics_of(tmp_path / "run")
    assert code == ACHIEVED
    assert len(metrics["stage_settling_s"]) == stages
    assert np.isfinite(metrics["stage_settling_s"]).all()
    assert metrics["collisions"] == 0


def test_the_losses_happen_and_the_ball_is_covered_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("coverage-losses", Family.COVERAGE, tmp_path / "run", *SHORTENED["coverage-losses"])

    metrics, told = metrics_of(tmp_path / "run"), capsys.readouterr().out
    assert metrics["lost_robots"] == 11
    assert "r00 dies, as the scenario says" in told
    assert metrics["covered_fraction"] > 0.99


def test_the_flock_moves_and_gathers_for_another_shape(tmp_path: Path) -> None:
    run("coverage-flock", Family.COVERAGE, tmp_path / "run", *SHORTENED["coverage-flock"])

    with np.load(tmp_path / "run" / "trajectories.npz") as arrays:
        leader = arrays["position"][:, 0]
    moved = leader[200] - leader[100]
    assert moved @ [0.5, 0.2, 0.0] > 15.0  # as ordered: 0.5 and 0.2 m/s for 100 s, plus noise of 1 m per second
    assert metrics_of(tmp_path / "run")["placed_robots"] < 5  # the ball has just been ordered


def test_no_scenario_with_events_or_stages_is_only_begun() -> None:
    scenarios = {name: load_any(name)[0] for name in scenario_names()}
    eventful = {
        name for name, scenario in scenarios.items() if any(getattr(scenario, key, ()) for key in ("stages", "events"))
    }

    assert eventful == {*SHORTENED, *SEEN_ELSEWHERE}
