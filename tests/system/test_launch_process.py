"""The launcher as people start it: a process with streams, signals and an exit code. In-process engine, no ROS."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from run_folders import FAST, FILES, metrics_of
from source_tree import ROOT

LAUNCHER = ROOT / "scripts" / "launch_swarm.py"
START_S, STOP_S, RUN_S = 60.0, 3.0, 120.0  # deadlines; only STOP_S is a promise


def launch(folder: Path, *options: str) -> subprocess.Popen[str]:
    command = [sys.executable, str(LAUNCHER), "--engine", "inprocess", *options]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_json_is_all_that_standard_output_carries_even_with_pybullet(tmp_path: Path) -> None:
    process = launch(tmp_path, "--scenario", "smoke-4", "--out", "run", "--json")
    out, err = process.communicate(timeout=RUN_S)

    assert process.returncode == 0, err
    assert json.loads(out) == metrics_of(tmp_path / "run")
    assert json.loads(out)["physics"] == "bullet"
    assert "shape formed" in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_ends_in_time_with_code_130_and_keeps_its_metrics(
    tmp_path: Path, number: signal.Signals
) -> None:
    process = launch(tmp_path, *FAST[2:], "--scenario", "smoke-4", "--real-time", "--out", "run")
    assert process.stdout is not None
    for line in process.stdout:
        if "at their goals" in line:  # the first tick has run; in real time, many more are to come
            break
    process.send_signal(number)
    began = time.monotonic()
    out, err = process.communicate(timeout=START_S)

    assert time.monotonic() - began < STOP_S
    assert process.returncode == 130, err
    assert "interrupted by the operator" in out
    assert metrics_of(tmp_path / "run")["ticks"] >= 1
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == [
        name for name in FILES if name != "figure.png"
    ]


def test_an_interruption_while_libraries_load_leaves_nothing(tmp_path: Path) -> None:
    process = launch(tmp_path, "--out", "run")
    maps = Path(f"/proc/{process.pid}/maps")
    until, pause = time.monotonic() + START_S, threading.Event()
    while "numpy" not in maps.read_text() and time.monotonic() < until:
        pause.wait(0.001)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=START_S)

    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_bad_input_is_one_line_on_standard_error(tmp_path: Path) -> None:
    process = launch(tmp_path, "--scenario", "dmo")
    out, err = process.communicate(timeout=START_S)

    assert process.returncode == 2
    assert out == ""
    assert err == "error: --scenario dmo: neither a ready-made scenario nor a file; did you mean 'demo'?\n"


def test_help_names_scenarios_and_exit_codes(tmp_path: Path) -> None:
    process = launch(tmp_path, "--help")
    out, _ = process.communicate(timeout=START_S)

    assert process.returncode == 0
    assert "demo, formation-50, formation-50-ideal, morph-50, sequence-50, smoke-4" in " ".join(out.split())
    assert "130: interrupted" in " ".join(out.split())
