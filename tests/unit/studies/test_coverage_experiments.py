"""The table of coverage experiments: one row per experiment, from real missions."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.coverage_experiments import EXPERIMENTS, main, settings_of
from swarm_agent.coverage.config import Expansion, Rule


def test_the_study_prints_a_row_per_experiment_and_goes_on_where_it_was(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    command = ["--experiment", "box", "--rule", "gain", "--expansion", "parallel", "--seeds", "1", "--sigma", "0"]
    codes = [main([*command, "--out", str(tmp_path)]) for _ in range(2)]

    _, row, _, again = capsys.readouterr().out.splitlines()
    assert codes == [0, 0]
    assert row.split()[:5] == ["box", "gain", "parallel", "1", "1"]
    assert again == row
    assert len((tmp_path / "results.jsonl").read_text(encoding="utf-8").splitlines()) == 1


def test_deaths_on_the_way_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--experiment", "box", "--seeds", "1", "--robots", "40", "--deaths", "0.5"]) == 0

    _, row, told = capsys.readouterr().out.splitlines()
    assert row.split()[:5] == ["box", "layout", "predicted", "1", "1"]
    assert told.split()[2:] == ["min,", "1", "component(s)", "at", "most"]


def test_a_folder_that_cannot_be_written_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()

    assert main(["--experiment", "box", "--seeds", "1", "--out", str(tmp_path / "file")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_plans_are_told_by_rule(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--plan", "--experiment", "box", "--rule", "gain", "--seeds", "1", "--sigma", "0"]) == 0

    row = capsys.readouterr().out.splitlines()[1].split()
    assert row[:3] == ["box", "gain", "1"]
    assert float(row[3]) <= 15
    assert float(row[5]) >= 0.999


def test_shorter_links_take_more_robots_and_impossible_ones_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    plan = ["--plan", "--experiment", "box", "--rule", "first", "--seeds", "1"]
    codes = [main([*plan, "--placement", share]) for share in ("0.9", "0.6", "2")]

    told = capsys.readouterr()
    robots = [float(line.split()[3]) for line in told.out.splitlines() if line.startswith("box")]
    assert codes == [0, 0, 2]
    assert robots[0] < robots[1]
    assert "placement" in told.err


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_agents_and_world_agree_on_the_ranges(name: str) -> None:
    agents, world = settings_of(name, Rule.LAYOUT, Expansion.SERIAL, 1.0)

    assert agents.range_m == world.radio.range_m == 0.5 * world.sight_m
    assert agents.motion.sigma_m == world.process_sigma_m
    assert agents.motion.speed_mps == world.speed_mps


def test_robots_keep_more_distance_to_the_range_where_there_is_noise() -> None:
    exact, noisy = (settings_of("box", Rule.GAIN, Expansion.SERIAL, sigma)[0].placement for sigma in (0.0, 1.0))

    assert (exact, noisy) == (0.95, 0.9)


def test_growth_is_told_by_radius_and_method(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--growth", "60", "--missions", "60"]) == 0

    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert [row[1] for row in rows] == ["frontier", "layout", "mission"]
    assert all(float(row[3]) > 0.999 for row in rows)
