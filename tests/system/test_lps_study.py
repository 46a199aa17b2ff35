"""The localization study as people run it: small, but from the command line to the figure."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from source_tree import ROOT

from studies.campaign_folder import RESULTS
from studies.lps_cli import CSV, FIGURE, TABLE, main

STUDY = ROOT / "scripts" / "lps_study.py"
SMALL = ["--agents", "14", "--duration", "12", "--warm-up", "6"]  # three beacons
FORMATION = [*SMALL, "--experiment", "formation", "--modes", "literal", "cooperative", "--periods", "3"]
RUN_S = 120.0


def run(out: Path, *options: str) -> int:
    return main([*options, "--out", str(out)])


def results(out: Path) -> dict[str, dict[str, object]]:
    lines = [json.loads(line) for line in (out / RESULTS).read_text().splitlines()]
    assert len({line["run"] for line in lines}) == len(lines)
    return {line["run"]: line["result"] for line in lines}


def test_a_small_study_leaves_results_tables_and_a_figure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(tmp_path, *FORMATION, "--seeds", "2", "--workers", "1") == 0

    numbers = results(tmp_path)
    with (tmp_path / CSV).open() as file:
        rows = list(csv.DictReader(file))
    assert len(numbers) == 2 * 2
    assert all(0.0 < float(str(scores["rms_m"])) < 10.0 for scores in numbers.values() if scores["lost_share"] != 1.0)
    assert any(scores["lost_share"] == 0.0 for scores in numbers.values())
    assert [(row["mode"], row["ranging"], row["period_s"], row["seeds"]) for row in rows] == [
        ("literal", "position", "3.0", "2"),
        ("cooperative", "range", "3.0", "2"),
    ]
    text = (tmp_path / TABLE).read_text()
    assert "## The study of the thesis" in text
    assert "## Targets" not in text  # they speak of fifty robots
    assert (tmp_path / FIGURE).read_bytes().startswith(b"\x89PNG")
    assert "literal" in capsys.readouterr().out


def test_the_numbers_do_not_depend_on_workers_nor_on_stops(tmp_path: Path) -> None:
    assert run(tmp_path / "alone", *FORMATION, "--seeds", "2", "--workers", "1") == 0
    assert run(tmp_path / "both", *FORMATION, "--seeds", "1", "--workers", "1") == 0
    first = (tmp_path / "both" / RESULTS).read_text()
    assert run(tmp_path / "both", *FORMATION, "--seeds", "2", "--workers", "2") == 0

    assert (tmp_path / "both" / RESULTS).read_text().startswith(first)  # what was done is not done again
    assert results(tmp_path / "both") == results(tmp_path / "alone")
    for name in (TABLE, CSV, FIGURE):
        assert (tmp_path / "both" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes()


def test_robots_that_wander_are_simulated_as_well(tmp_path: Path) -> None:
    options = [*FORMATION, "--seeds", "1", "--workers", "1"]
    assert run(tmp_path, *options) == 0
    assert run(tmp_path, *options, "--motion", "wander") == 0

    at_rest, wandering = ([v for k, v in results(tmp_path).items() if k.count("wander") == n] for n in (0, 1))
    assert len(at_rest) == len(wandering) == 2
    assert at_rest != wandering


def test_a_mission_reports_how_it_ended_and_how_well_it_was_localized(tmp_path: Path) -> None:
    options = ["--agents", "7", "--experiment", "mission", "--periods", "0", "--seeds", "1", "--workers", "1"]
    assert run(tmp_path, *options) == 0

    (scores,) = results(tmp_path).values()
    assert scores["achieved"] is True
    assert scores["collisions"] == 0
    assert "| 1 of 1 | 0 |" in (tmp_path / TABLE).read_text()
    assert not (tmp_path / FIGURE).exists()


@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_ends_at_once_and_keeps_what_was_done(tmp_path: Path, workers: str) -> None:
    # A short run, then some of ten hours of simulated time: the stop comes in the middle of them.
    short = [*SMALL, "--experiment", "formation", "--modes", "literal", "--periods", "3", "--out", str(tmp_path)]
    assert main([*short, "--seeds", "1", "--workers", "1"]) == 0
    command = [sys.executable, str(STUDY), *short, "--duration", "36000", "--workers", workers]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert "0 of 30 runs are done" in process.stderr.readline()  # the study is under way
    process.send_signal(signal.SIGINT)
    began = time.monotonic()
    out, _ = process.communicate(timeout=RUN_S)

    assert process.returncode == 130
    assert "0 of 30 runs are done" in out
    assert time.monotonic() - began < 10.0
    assert len(results(tmp_path)) == 1


def test_bad_input_is_one_line_and_exit_code_2(tmp_path: Path) -> None:
    command = [sys.executable, str(STUDY), "--modes", "gps"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=RUN_S, check=False)

    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "--modes: there is no 'gps'" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")

    assert run(tmp_path / "file" / "below", *FORMATION) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_tables_are_made_anew_without_a_simulation(tmp_path: Path) -> None:
    assert run(tmp_path, *FORMATION, "--seeds", "1", "--workers", "1") == 0
    table = (tmp_path / TABLE).read_text()
    (tmp_path / TABLE).unlink()

    assert run(tmp_path, *FORMATION, "--seeds", "1", "--tables-only") == 0
    assert (tmp_path / TABLE).read_text() == table


def test_results_of_other_code_are_told_in_the_table_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(tmp_path, *FORMATION, "--seeds", "1", "--workers", "1") == 0
    assert "other code" not in (tmp_path / TABLE).read_text()
    entries = [json.loads(line) for line in (tmp_path / RESULTS).read_text().splitlines()]
    entries[0]["code"] = "older"
    (tmp_path / RESULTS).write_text("".join(json.dumps(entry) + "\n" for entry in entries))

    assert run(tmp_path, *FORMATION, "--seeds", "1", "--tables-only") == 0
    assert "warning: 1 of the results" in (tmp_path / TABLE).read_text()
    assert "warning: 1 of the results" in capsys.readouterr().err
