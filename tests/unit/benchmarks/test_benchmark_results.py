"""What the benchmarks keep of finished runs, and take up again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path

import formation
import pytest
import robustness
from robustness import KEPT, Task
from robustness_watch import WATCHED

from bringup.results import FormationMetrics

NUMBERS: dict[str, object] = {
    **dict.fromkeys(KEPT, 1.0),
    **dict.fromkeys(WATCHED, 1.0),
    "achieved": True,
    "reason": "",
    "collisions": 0,
}


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the list that the seeds of performed runs of `robustness` go to; none is simulated."""
    seeds: list[int] = []

    def perform(tasks: Sequence[Task], processes: int) -> Iterator[tuple[Task, Mapping[str, object]]]:
        assert processes == 1
        for task in tasks:
            seeds.append(task.seed)
            yield task, {**asdict(task), **NUMBERS}

    monkeypatch.setattr(robustness, "_completed", perform)
    return seeds


def split(out: Path, *seeds: int) -> int:
    return robustness.main(["split", "--processes", "1", "--out", str(out), "--seeds", *map(str, seeds)])


def test_finished_runs_are_not_run_again(tmp_path: Path, ran: list[int]) -> None:
    out = tmp_path / "new" / "runs.jsonl"

    assert split(out, 1, 2) == 0
    assert split(out, 1, 2, 3) == 0
    assert ran == [1, 2, 3]


def test_a_line_that_was_cut_off_costs_one_run_and_not_the_next_one(tmp_path: Path, ran: list[int]) -> None:
    out = tmp_path / "runs.jsonl"
    split(out, 1, 2)
    out.write_text(out.read_text()[:-40])

    assert split(out, 1, 2, 3) == 0
    assert split(out, 1, 2, 3) == 0
    assert ran == [1, 2, 2, 3]


@pytest.mark.parametrize("line", ['{"variant": "x"}', "[]", "{", '{"run": "r", "code": "c", "result": 1}'])
def test_a_line_that_is_no_result_counts_as_none(line: str, tmp_path: Path, ran: list[int]) -> None:
    out = tmp_path / "runs.jsonl"
    out.write_text(f"{line}\n")

    assert split(out, 1) == 0
    assert ran == [1]


def test_a_result_that_lacks_a_number_is_made_anew(tmp_path: Path, ran: list[int]) -> None:
    out = tmp_path / "runs.jsonl"
    split(out, 1)
    entry = json.loads(out.read_text())
    del entry["result"]["localization_rmse_m"]
    out.write_text(json.dumps(entry) + "\n")

    assert split(out, 1) == 0
    assert ran == [1, 1]


def test_results_of_other_code_are_told_below_the_table(
    tmp_path: Path, ran: list[int], capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "runs.jsonl"
    split(out, 1, 2)
    assert "other code" not in capsys.readouterr().out
    first, second = map(json.loads, out.read_text().splitlines())
    out.write_text(json.dumps({**first, "code": "older"}) + "\n" + json.dumps(second) + "\n")

    assert split(out, 1, 2) == 0
    assert "**warning: 1 of the results in" in capsys.readouterr().out
    assert ran == [1, 2]


def test_a_missed_target_is_the_exit_code(tmp_path: Path, ran: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(NUMBERS, "agreed_after_s", 11.0)

    assert split(tmp_path / "runs.jsonl", 1) == 1
    assert ran == [1]


def test_an_unreadable_file_of_results_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "runs.jsonl").write_bytes(b"\xff")

    assert split(tmp_path / "runs.jsonl", 1) == 2
    assert formation.main(["--out", str(tmp_path / "runs.jsonl")]) == 2
    assert capsys.readouterr().err.count("error: ") == 2


def test_the_formation_table_takes_up_whole_results_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    metrics = dict.fromkeys((field.name for field in fields(FormationMetrics)), 1.0) | {"achieved": True}
    ran: list[int] = []

    def perform(_scenario: str, seed: int, _options: Sequence[str]) -> dict[str, object]:
        ran.append(seed)
        return {**metrics, "seed": seed, "collisions": 0}

    monkeypatch.setattr(formation, "_run", perform)
    out = tmp_path / "runs.jsonl"
    command = ["--table", "quality", "--out", str(out), "--seeds"]

    assert formation.main([*command, "1", "2"]) == 0
    out.write_text(out.read_text()[:-20])
    assert formation.main([*command, "1", "2", "3"]) == 0
    assert formation.main([*command, "1", "2", "3"]) == 0
    assert ran == [1, 2, 2, 3]
