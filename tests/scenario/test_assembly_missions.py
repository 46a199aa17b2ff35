"""Assembly scenarios as an operator runs them: by name, in process, with a run folder; and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bringup.cli import main

QUICK = ("--engine", "inprocess", "--physics", "massdamper")


def launched(tmp_path: Path, *arguments: str) -> tuple[int, Path]:
    out = tmp_path / "run"
    return main([*arguments, *QUICK, "--out", str(out)]), out


def test_a_scenario_by_name_builds_its_structure_and_says_so(tmp_path: Path) -> None:
    code, out = launched(tmp_path, "--scenario", "assembly-line")

    metrics = json.loads((out / "metrics.json").read_text())
    assert (code, metrics["achieved"], metrics["family"]) == (0, True, "assembly")
    assert (metrics["filled_places"], metrics["places"], metrics["docked_edges"]) == (4, 4, 3)
    assert (metrics["components"], metrics["collisions"], metrics["docks_torn"]) == (1, 0, 0)
    assert metrics["plan_wall_s"] > 0.0
    with np.load(out / "trajectories.npz") as arrays:
        assert arrays["position"].shape == (metrics["ticks"] + 1, 4, 2)
        assert len(arrays["latches"]) == 3
    assert (out / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_without_a_spare_a_death_leaves_the_largest_part_and_the_reason(tmp_path: Path) -> None:
    code, out = launched(tmp_path, "--scenario", "assembly-l", "--set", "events=[{at_s: 4.0, kill: [3]}]")

    metrics = json.loads((out / "metrics.json").read_text())
    assert code == 1
    assert metrics["filled_places"] == 3
    assert "boat 3 fell silent" in metrics["reason"]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--map", "map_9"), "--map map_9: map 'map_9' is neither a map nor a file"),
        (("--agents", "7"), "--agents 7: the map says how many boats there are"),
        (("--shape", "letter_h"), "--shape letter_h: what boats build is a map"),
        (("--set", "events=[{at_s: 1.0, kill: [9]}]"), "there is no r09; the map has 4 boats"),
        (("--set", "events=[{at_s: 1.0, magnets: [{boat: 1, side: top}]}]"), "side is 'top'"),
    ],
)
def test_bad_input_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], expected: str
) -> None:
    code, out = launched(tmp_path, "--scenario", "assembly-line", *arguments)

    printed = capsys.readouterr().err.strip()
    assert code == 2
    assert expected in printed
    assert "\n" not in printed
    assert not out.exists()


def test_layouts_that_cannot_join_are_refused_with_a_proof(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = {
        "grid_size": [12, 12],
        "targets": [[5, 5], [6, 5], [7, 5]],
        "starts": [[1, 1], [4, 1], [8, 1]],
        "docks_genderless": [[1, 0, 0, 0]] * 3,
    }
    path = tmp_path / "pairs.json"
    path.write_text(json.dumps(record))

    code, _ = launched(tmp_path, "--scenario", "assembly-line", "--map", str(path))

    assert code == 2
    assert "no dispatch" in capsys.readouterr().err
