"""The table of coverage experiments: one row per experiment, from real missions."""

from __future__ import annotations

import pytest

from studies.coverage_experiments import EXPERIMENTS, main, settings_of
from swarm_agent.coverage.config import Expansion, Rule


def test_the_study_prints_a_row_per_experiment(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["--experiment", "box", "--rule", "gain", "--expansion", "parallel", "--seeds", "1", "--sigma", "0"])

    _, row = capsys.readouterr().out.splitlines()
    assert code == 0
    assert row.split()[:5] == ["box", "gain", "parallel", "1", "1"]


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
