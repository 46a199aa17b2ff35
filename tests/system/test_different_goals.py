"""A robot that finds other goals than the mission computer is told of, in the run and in its numbers."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bringup.cli import main
from swarm_agent import agent
from swarm_msgs_py.plan_goals import goals_crc

WORDS = ["--scenario", "smoke-4", "--engine", "inprocess", "--physics", "massdamper", "--set", "duration_s=4"]


def agreed(out: Path, method: str) -> object:
    main([*WORDS, "--method", method, "--out", str(out)])
    return json.loads((out / "metrics.json").read_text())["goals_agreed"]


def test_robots_that_find_the_same_goals_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert agreed(tmp_path / "run", "voronoi") is True
    captured = capsys.readouterr()
    assert "other goals" not in captured.out + captured.err


def test_other_goals_are_an_alert_and_in_the_metrics(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agent, "goals_crc", lambda goals, types: goals_crc(goals, types) ^ 1)

    assert agreed(tmp_path / "run", "voronoi") is False
    captured = capsys.readouterr()
    assert "r03 found other goals for plan 1 than the mission computer" in captured.out + captured.err


def test_goals_that_the_plan_names_need_no_agreement(tmp_path: Path) -> None:
    assert agreed(tmp_path / "run", "bubble-packing") is None
