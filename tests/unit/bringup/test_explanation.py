from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from bringup.cli import main
from bringup.explanation import explain, scenario_list
from bringup.resolution import resolve
from bringup.scenario import Scenario
from bringup.scenario_file import load_any, load_scenario, scenario_names
from swarm_msgs_py.config import dotted_keys

LONGEST = 110  # characters of a description, so that a list has one line per scenario


@pytest.fixture(scope="module")
def resolved() -> Scenario:
    return resolve(*load_scenario("smoke-4"))


def test_an_explained_scenario_can_be_run_again(resolved: Scenario, tmp_path: Path) -> None:
    file = tmp_path / "explained.yaml"
    file.write_text(explain(resolved), encoding="utf-8")

    assert load_scenario(str(file))[0] == resolved


def test_every_setting_is_explained_with_its_unit(resolved: Scenario) -> None:
    text = explain(resolved)

    for key, (_, about) in dotted_keys(Scenario).items():
        name = key.rpartition(".")[2]
        assert any(line.split("#")[0].strip(" -").startswith(f"{name}:") for line in text.splitlines()), key
        assert about.help in text, key
    assert "duration_s: 60.0" in text
    assert "# [s] simulated time after which the mission counts as failed (> 0 s)" in text


def test_the_command_line_prints_the_scenario_that_it_would_run(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["--explain", "--scenario", "smoke-4", "--set", "radio.loss=0.25", "--seed", "7"])

    data = yaml.safe_load(capsys.readouterr().out)
    assert code == 0
    assert (data["seed"], data["sim"]["radio"]["loss"], data["shape"]["points"][0]) == (7, 0.25, [-1.0, -1.0])


def test_a_scenario_with_a_mistake_is_not_explained(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["--explain", "--set", "radio.lose=0.25"])

    assert code == 2
    assert (
        capsys.readouterr().err == "error: --set radio.lose: unknown key 'radio.lose'; did you mean 'sim.radio.loss'?\n"
    )


def test_the_list_has_every_scenario_with_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list-scenarios"]) == 0

    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == list(scenario_names())
    assert scenario_list().splitlines() == lines


@pytest.mark.parametrize("name", scenario_names())
def test_ready_made_scenarios_have_a_description_of_one_line(name: str) -> None:
    description = load_any(name)[0].description

    assert 20 <= len(description) <= LONGEST
    assert "\n" not in description
