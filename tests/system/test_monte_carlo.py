"""Monte Carlo batches as people run them: small, but from the command line to the table, and ended in every way."""

from __future__ import annotations

import csv
import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from pyarrow import parquet
from small_batch import DEADLINE_S, METHODS, SCRIPT, SMALL, batch, entries, metrics_of

from batches import cli
from batches.cells import Run
from batches.cli import CSV, FIGURE, RUNS, SUMMARY, main
from batches.folder_cells import CELLS
from batches.performing import Performed, perform
from bringup.scenario_file import SCENARIOS, load_scenario
from studies.campaign import WorkerDiedError
from studies.campaign_folder import RESULTS, locked


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a batch of two methods and two seeds that nothing disturbed."""
    out = tmp_path_factory.mktemp("alone")
    assert batch(out, "--seeds", "2", "--workers", "1") == 0
    return out


def test_a_batch_leaves_runs_summary_and_figure(alone: Path) -> None:
    table = parquet.read_table(alone / RUNS)
    with (alone / CSV).open() as file:
        rows = list(csv.DictReader(file))

    assert sorted(zip(table["method"].to_pylist(), table["seed"].to_pylist(), strict=True)) == [
        (method, seed) for method in METHODS[1:] for seed in (1, 2)
    ]
    assert table["achieved"].to_pylist() == [True] * 4
    assert all(run_s > 0.0 for run_s in table["run_s"].to_pylist())
    achieved = {row["method"]: row for row in rows if row["quantity"] == "achieved"}
    assert {method: row["mean"] for method, row in achieved.items()} == {"bubble-packing": "1", "fractals": "1"}
    assert achieved["fractals"]["pairs"] == "2"
    assert "## smoke-4, hw_2_square" in (alone / SUMMARY).read_text()
    assert (alone / FIGURE).read_bytes().startswith(b"\x89PNG")


def test_seeds_that_are_added_are_all_that_is_run(alone: Path, tmp_path: Path) -> None:
    assert batch(tmp_path, "--seeds", "1", "--workers", "1") == 0
    first = (tmp_path / RESULTS).read_text()
    assert batch(tmp_path, "--seeds", "2", "--workers", "1") == 0

    assert (tmp_path / RESULTS).read_text().startswith(first)
    assert metrics_of(tmp_path) == metrics_of(alone)
    for name in (SUMMARY, CSV, FIGURE):
        assert (tmp_path / name).read_bytes() == (alone / name).read_bytes()


def test_a_line_that_was_cut_off_costs_one_run(alone: Path, tmp_path: Path) -> None:
    text = (alone / RESULTS).read_text()
    (tmp_path / RESULTS).write_text(text[:-7])
    assert batch(tmp_path, "--seeds", "2", "--workers", "1") == 0

    lines = (tmp_path / RESULTS).read_text().splitlines()
    assert lines[:3] == text.splitlines()[:3]
    assert len(lines) == 5
    for name in (SUMMARY, CSV, FIGURE):
        assert (tmp_path / name).read_bytes() == (alone / name).read_bytes()


def test_tables_are_made_anew_without_a_simulation(alone: Path, tmp_path: Path) -> None:
    (tmp_path / RESULTS).write_text((alone / RESULTS).read_text())

    assert batch(tmp_path, "--seeds", "2", "--tables-only") == 0
    assert len(entries(tmp_path)) == 4
    for name in (RUNS, SUMMARY, CSV, FIGURE):
        assert (tmp_path / name).read_bytes() == (alone / name).read_bytes()


def test_results_of_other_code_are_told_apart(alone: Path, tmp_path: Path) -> None:
    first, *rest = entries(alone)
    lines = [json.dumps(entry) + "\n" for entry in ({**first, "code": "older"}, *rest)]
    (tmp_path / RESULTS).write_text("".join(lines))

    assert batch(tmp_path, "--seeds", "2", "--tables-only") == 0
    assert "1 results of other code are left out" in (tmp_path / SUMMARY).read_text()
    assert "older" not in parquet.read_table(tmp_path / RUNS)["code_version"].to_pylist()

    assert batch(tmp_path, "--seeds", "2", "--tables-only", "--keep-outdated") == 0
    assert "**warning: 1 of the results" in (tmp_path / SUMMARY).read_text()
    versions = parquet.read_table(tmp_path / RUNS)["code_version"].to_pylist()
    assert sorted(version == "older" for version in versions) == [False, False, False, True]


def test_results_of_other_code_are_made_anew(alone: Path, tmp_path: Path) -> None:
    first, *rest = entries(alone)
    lines = [json.dumps(entry) + "\n" for entry in ({**first, "code": "older"}, *rest)]
    (tmp_path / RESULTS).write_text("".join(lines))

    assert batch(tmp_path, "--seeds", "2", "--workers", "1") == 0
    assert len(entries(tmp_path)) == 5
    assert entries(tmp_path)[-1]["run"] == first["run"]
    for name in (SUMMARY, CSV, FIGURE):
        assert (tmp_path / name).read_bytes() == (alone / name).read_bytes()


def test_a_command_that_asks_for_less_takes_nothing_out_of_the_tables(alone: Path, tmp_path: Path) -> None:
    shutil.copytree(alone, tmp_path / "copy")
    words = ["--scenario", "smoke-4", "--method", "fractals", "--seeds", "2:2", "--tables-only"]
    assert main([*words, "--out", str(tmp_path / "copy")]) == 0

    table = parquet.read_table(tmp_path / "copy" / RUNS)
    assert sorted(zip(table["method"].to_pylist(), table["seed"].to_pylist(), strict=True)) == [
        (method, seed) for method in METHODS[1:] for seed in (1, 2)
    ]
    assert "3 more runs are of earlier commands" in (tmp_path / "copy" / SUMMARY).read_text()


def test_runs_of_one_name_but_other_settings_do_not_get_into_one_folder(
    alone: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (alone / RESULTS).read_bytes()

    assert batch(alone, "--seeds", "2", "--set", "success.hold_s=4") == 2
    captured = capsys.readouterr()
    assert "has results of 'smoke-4, hw_2_square, bubble-packing, total' with other settings" in captured.err
    assert captured.err.count("\n") == 1
    assert (alone / RESULTS).read_bytes() == before


def test_the_cells_of_a_folder_are_scenarios_that_can_be_run_again(alone: Path) -> None:
    paths = sorted((alone / CELLS).glob("*.yaml"))

    assert sorted(load_scenario(str(path))[0].method for path in paths) == METHODS[1:]


def test_a_second_batch_in_the_same_folder_is_refused(
    alone: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / RESULTS).write_text((alone / RESULTS).read_text())
    with locked(tmp_path):
        assert batch(tmp_path, "--seeds", "3") == 2
        captured = capsys.readouterr()
        assert "another process is writing results there" in captured.err
        assert captured.err.count("\n") == 1
        assert batch(tmp_path, "--seeds", "2", "--tables-only") == 0  # who only reads may look meanwhile

    assert len(entries(tmp_path)) == 4


def test_turned_shapes_are_formed_in_another_orientation_for_every_seed(tmp_path: Path) -> None:
    options = [*SMALL, "--seeds", "2", "--workers", "1", "--turns", "--out", str(tmp_path)]
    assert main(options) == 0

    table = parquet.read_table(tmp_path / RUNS)
    bounds = table["displacement_lower_bound_m"].to_pylist()
    assert len(set(bounds)) == 4
    assert all("-turned, seed" in run for run in table["run"].to_pylist())
    before = (tmp_path / CSV).read_bytes()
    assert main([*options, "--tables-only"]) == 0
    assert (tmp_path / CSV).read_bytes() == before


@contextmanager
def under_way(out: Path, endless: Path) -> Iterator[subprocess.Popen[str]]:
    """Start a batch in a process of its own, and wait until all that is left of it is runs of ten hours."""
    text = (SCENARIOS / "smoke-4.yaml").read_text()
    text = text.replace("name: smoke-4", "name: endless").replace("duration_s: 60.0", "duration_s: 36000.0")
    endless.write_text(text.replace("success: {", "success: {hold_s: 36000.0, "))
    words = ["--scenario", "smoke-4", str(endless), "--method", "fractals", "--seeds", "2", "--workers", "2"]
    command = [sys.executable, str(SCRIPT), *words, "--out", str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            assert "0 of 4 runs are done" in process.stderr.readline()
            wait_for_lines(out / RESULTS, 2, process)
            yield process
        finally:
            process.kill()


def wait_for_lines(path: Path, count: int, process: subprocess.Popen[str]) -> None:
    while not path.exists() or path.read_text().count("\n") < count:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=0.05)  # it must still be running


def test_ctrl_c_keeps_what_is_done_and_the_same_command_goes_on(alone: Path, tmp_path: Path) -> None:
    with under_way(tmp_path, tmp_path / "endless.yaml") as process:
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=DEADLINE_S)

    assert process.returncode == 130
    assert "2 of 4 runs are done; the same command goes on" in out
    assert len(metrics_of(tmp_path)) == 2
    assert metrics_of(tmp_path).items() < metrics_of(alone).items()  # of two workers as of one
    assert parquet.read_table(tmp_path / RUNS).num_rows == 2
    before = (tmp_path / RESULTS).read_text()
    assert batch(tmp_path, "--seeds", "2", "--workers", "1") == 0
    assert (tmp_path / RESULTS).read_text().startswith(before)
    assert metrics_of(tmp_path) == metrics_of(alone)


def test_a_batch_that_is_killed_loses_only_what_was_under_way(alone: Path, tmp_path: Path) -> None:
    with under_way(tmp_path, tmp_path / "endless.yaml") as process:
        process.kill()
        process.wait(timeout=DEADLINE_S)

    assert len(metrics_of(tmp_path)) == 2
    assert batch(tmp_path, "--seeds", "2", "--workers", "1") == 0
    assert metrics_of(tmp_path) == metrics_of(alone)


def test_a_worker_that_dies_ends_the_batch_with_tables_of_what_is_done(
    alone: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def completed_until_a_worker_dies(runs: Sequence[Run], *_: object) -> Iterator[tuple[Run, Performed]]:
        for run in runs[:3]:
            yield run, perform(run)
        raise WorkerDiedError("a worker process died; run the same command again")

    monkeypatch.setattr(cli, "completed", completed_until_a_worker_dies)

    assert batch(tmp_path, "--seeds", "2") == 1
    assert "a worker process died; run the same command again" in capsys.readouterr().err
    assert metrics_of(tmp_path).items() < metrics_of(alone).items()
    assert parquet.read_table(tmp_path / RUNS).num_rows == 3
    assert "3 of 4 runs are done" in (tmp_path / SUMMARY).read_text()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--method", "bubbles"], "bubble-packing"),
        (["--shape", "formation_9"], "formation_"),
        (["--scenario", "no-such"], "neither a ready-made scenario nor a file"),
        (["--seeds", "none"], "--seeds: expected a count N or a range A:B"),
        (["--set", "radio.loss=2"], "--set radio.loss"),
        (["--shape", "iso_1_circle"], "shape"),  # far too large for the yard
        (["--scheduler", "nonsense://x"], "no Dask scheduler answers there"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    options: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert batch(tmp_path / "out", "--seeds", "1", *options) == 2

    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""
    assert not (tmp_path / "out").exists()


def test_the_ideal_fifty_can_be_run_with_fewer(tmp_path: Path) -> None:
    options = ["--method", "voronoi", "--agents", "5", "--seeds", "1", "--workers", "1", "--out", str(tmp_path)]
    assert main(options) == 0

    table = parquet.read_table(tmp_path / RUNS)
    assert table["scenario"].to_pylist() == ["formation-50-ideal"]
    assert table["achieved"].to_pylist() == [True]
    assert table["localization_max_m"].to_pylist()[0] < 1e-3
