"""Every ready-made scenario runs: its first seconds here, its outcome where that is told of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from run_folders import metrics_of

from bringup.cli import main
from bringup.family import Family
from bringup.scenario_file import scenario_names

SECONDS = {Family.FORMATION: 6.0, Family.COVERAGE: 14.0, Family.ASSEMBLY: 6.0}
"""Long enough for the first plan to reach the swarm, or for its first robots to visit their ancestors."""
NOT_ACHIEVED = 1
OPTIONS = {
    Family.FORMATION: ("--physics", "massdamper", "--set", "stages=[]"),
    Family.COVERAGE: ("--set", "events=[]"),
    Family.ASSEMBLY: ("--physics", "massdamper"),
}


@pytest.mark.parametrize(
    ("name", "family"), [(name, family) for family in Family for name in scenario_names(family)], ids=str
)
def test_a_ready_made_scenario_runs_and_sets_robots_going(name: str, family: Family, tmp_path: Path) -> None:
    out = tmp_path / "run"
    options = ("--set", f"duration_s={SECONDS[family]:g}", *OPTIONS[family])

    code = main(["--engine", "inprocess", "--out", str(out), "--scenario", name, *options])

    metrics = metrics_of(out)
    assert code == NOT_ACHIEVED  # nobody is there so soon
    assert metrics["scenario"] == name
    assert metrics["sim_time_s"] == pytest.approx(SECONDS[family], abs=0.5)
    assert metrics["total_displacement_m"] > 0.02 * metrics["robots"]
    if family is Family.FORMATION:
        assert np.isfinite(metrics["localization_rmse_m"])
