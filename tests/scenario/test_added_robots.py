from __future__ import annotations

from pathlib import Path

from run_folders import metrics_of, run_in_process

ADDED_S = 25.0


def test_a_robot_that_is_added_late_takes_its_place_and_is_waited_for(tmp_path: Path) -> None:
    out = tmp_path / "run"

    code = run_in_process(out, "--scenario", "smoke-4", "--set", f"events=[{{at_s: {ADDED_S}, add: [3]}}]")

    metrics = metrics_of(out)
    assert code == 0, metrics["reason"]
    assert (metrics["goals_reached"], metrics["lost_robots"]) == (4, 0)
    assert metrics["sim_time_s"] > ADDED_S
