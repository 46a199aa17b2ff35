"""Runs that nobody looks after any more: a reader that leaves, a terminal that closes, a launcher that is killed."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from run_folders import FAST, FILES, metrics_of
from source_tree import ROOT

from reports import plot_cli

LAUNCHER = ROOT / "scripts" / "launch_swarm.py"
RUN_S = 120.0


def launch(folder: Path, *options: str) -> subprocess.Popen[str]:
    command = [sys.executable, str(LAUNCHER), *FAST, "--scenario", "smoke-4", "--out", "run", *options]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for_line(process: subprocess.Popen[str], text: str) -> None:
    assert process.stdout is not None
    assert any(text in line for line in process.stdout), f"no line with '{text}'"


@pytest.mark.parametrize("options", [(), ("--json",)], ids=["plain", "json"])
def test_a_reader_that_leaves_costs_neither_results_nor_exit_code(tmp_path: Path, options: tuple[str, ...]) -> None:
    process = launch(tmp_path, *options)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()  # as `head` does, only sooner
    err = process.stderr.read()
    process.wait(RUN_S)

    assert process.returncode == 0, err
    assert "Broken" not in err
    assert metrics_of(tmp_path / "run")["achieved"] is True
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == sorted(FILES)


def test_a_terminal_that_closes_ends_the_run_like_an_interruption(tmp_path: Path) -> None:
    process = launch(tmp_path, "--real-time")
    wait_for_line(process, "at their goals")
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=RUN_S)

    assert process.returncode == 130
    assert str(metrics_of(tmp_path / "run")["reason"]).startswith("interrupted by the operator")


def test_a_killed_launcher_leaves_a_readable_folder(tmp_path: Path) -> None:
    process = launch(tmp_path, "--real-time")
    wait_for_line(process, "at their goals")
    wanted, until = tmp_path / "run" / "trajectories.npz", time.monotonic() + RUN_S
    while not wanted.exists():  # the save after the first tick is under way
        assert time.monotonic() < until
    process.kill()
    process.communicate(timeout=RUN_S)

    metrics = json.loads((tmp_path / "run" / "metrics.json").read_text())
    assert (tmp_path / "run" / "scenario.yaml").exists()
    assert metrics["reason"].startswith("still running")
    assert metrics["achieved"] is False
    report = tmp_path / "report.html"
    assert plot_cli.main([str(tmp_path / "run"), "--out", str(report)]) == 0
    assert "still running" in report.read_text()


@pytest.mark.parametrize("closed", ["1>&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_descriptors_cost_neither_results_nor_exit_code(tmp_path: Path, closed: str) -> None:
    options = " ".join([*FAST, "--scenario", "smoke-4", "--out", "run"])
    shell = subprocess.run(
        ["sh", "-c", f"exec {sys.executable} {LAUNCHER} {options} {closed}"], cwd=tmp_path, check=False
    )

    assert shell.returncode == 0
    assert metrics_of(tmp_path / "run")["achieved"] is True
