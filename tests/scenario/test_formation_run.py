"""A whole run in one process: what it does, and what it leaves behind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from run_folders import FAST, FILES, metrics_of, png_size, run_in_process

from bringup.cli import main

COMMON_KEYS = [
    *("scenario", "family", "method", "seed", "engine", "physics", "robots", "achieved", "reason", "ticks"),
    *("sim_time_s", "wall_time_s", "real_time_factor", "startup_s", "total_displacement_m"),
    *("displacement_lower_bound_m", "settling_time_s", "collisions", "min_clearance_m", "localization_rmse_m"),
    *("localization_max_m", "radio_frames", "radio_bytes", "radio_peak_bps", "lost_robots"),
    "radio_neighborhood_peak_bps",
]
FORMATION_KEYS = ["mesh_topological", "mesh_geometrical", "goals_reached"]
WALL_KEYS = {"wall_time_s", "real_time_factor", "startup_s"}


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a finished demo run."""
    folder = tmp_path_factory.mktemp("demo") / "run"
    assert run_in_process(folder) == 0
    return folder


def test_the_demo_forms_its_shape_without_a_collision(demo: Path) -> None:
    metrics = metrics_of(demo)

    assert metrics["achieved"]
    assert metrics["robots"] == metrics["goals_reached"] == 12
    assert metrics["collisions"] == 0
    assert metrics["min_clearance_m"] > 0.0
    assert metrics["inside_fraction"] == 1.0


def test_the_demo_drives_little_more_than_it_must(demo: Path) -> None:
    metrics = metrics_of(demo)

    assert metrics["total_displacement_m"] <= 1.10 * metrics["displacement_lower_bound_m"]
    assert metrics["settling_time_s"] <= 1.25 * metrics["bottleneck_time_s"] + 10.0


def test_the_metrics_have_every_key_of_the_contract(demo: Path) -> None:
    metrics = metrics_of(demo)

    assert [key for key in (*COMMON_KEYS, *FORMATION_KEYS) if key not in metrics] == []
    assert [key for key in (*COMMON_KEYS, *FORMATION_KEYS) if metrics[key] is None] == []
    assert metrics["sim_time_s"] == pytest.approx(metrics["ticks"] * 0.5)
    assert metrics["real_time_factor"] == pytest.approx(metrics["sim_time_s"] / metrics["wall_time_s"])


def test_the_folder_holds_what_it_should_and_nothing_half_written(demo: Path) -> None:
    assert sorted(path.name for path in demo.iterdir()) == FILES


def test_the_figure_is_large_enough_to_print(demo: Path) -> None:
    width, height = png_size(demo / "figure.png")

    assert width >= 1500
    assert height >= 800


def test_the_trajectories_end_where_the_metrics_say(demo: Path) -> None:
    metrics = metrics_of(demo)
    with np.load(demo / "trajectories.npz") as arrays:
        time, position, goals = arrays["time"], arrays["position"], arrays["goals"]
        goal, sizes, corners = arrays["goal"], arrays["obstacle_sizes"], arrays["obstacle_corners"]

    assert time[0] == 0.0
    assert time[-1] == pytest.approx(metrics["sim_time_s"])
    assert (np.diff(time) <= 0.1 + 1e-9).all()  # true positions at 10 Hz or more
    assert position.shape == (len(time), 12, 2)
    assert sorted(goal[-1]) == list(range(12))
    assert np.linalg.norm(position[-1] - goals[goal[-1]], axis=1).max() <= 1.0  # success.goal_tolerance_m
    assert sizes.sum() == len(corners)


def test_the_written_scenario_runs_again_to_the_same_bytes(demo: Path, tmp_path: Path) -> None:
    again = tmp_path / "again"

    assert run_in_process(again, "--scenario", str(demo / "scenario.yaml")) == 0
    assert (again / "trajectories.npz").read_bytes() == (demo / "trajectories.npz").read_bytes()
    assert (again / "scenario.yaml").read_bytes() == (demo / "scenario.yaml").read_bytes()
    first, second = metrics_of(demo), metrics_of(again)
    assert {key for key in first if first[key] != second[key]} <= WALL_KEYS


def test_another_seed_is_another_run(demo: Path, tmp_path: Path) -> None:
    assert run_in_process(tmp_path / "run", "--seed", "2") == 0

    assert metrics_of(tmp_path / "run")["seed"] == 2
    assert (tmp_path / "run" / "trajectories.npz").read_bytes() != (demo / "trajectories.npz").read_bytes()


def test_a_run_out_of_time_ends_with_code_1_and_the_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = run_in_process(tmp_path / "run", "--set", "duration_s=5")

    metrics = metrics_of(tmp_path / "run")
    assert code == 1
    assert not metrics["achieved"]
    assert metrics["ticks"] == 10
    assert metrics["reason"].startswith("time limit of 5 s")
    assert metrics["reason"] in capsys.readouterr().out
    assert metrics["settling_time_s"] is None
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == FILES


def test_robots_without_position_sensor_are_the_stated_reason(tmp_path: Path) -> None:
    blind = ("--set", "position_sensor_share=0", "--set", "known_within_m=null", "--set", "duration_s=5")

    assert run_in_process(tmp_path / "run", "--scenario", "smoke-4", *blind) == 1
    assert "4 have no position" in metrics_of(tmp_path / "run")["reason"]
    assert metrics_of(tmp_path / "run")["localization_rmse_m"] is None


def test_a_single_robot_is_a_swarm(tmp_path: Path) -> None:
    assert run_in_process(tmp_path / "run", "--scenario", "smoke-4", "--agents", "1") == 0

    metrics = metrics_of(tmp_path / "run")
    assert metrics["robots"] == 1
    assert metrics["mesh_topological"] is None
    assert metrics["displacement_ratio"] == pytest.approx(1.0, abs=0.05)


def test_the_default_folder_is_named_after_time_scenario_and_seed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    assert main([*FAST, "--scenario", "smoke-4", "--seed", "7"]) == 0
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name.endswith("-smoke-4-7")
