"""The launcher with the ROS engine, as people start it: real processes, PyBullet, files, signals and exit codes."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from leftovers import children_of, orphaned, session_members, shared_memory, wait_until
from run_folders import FILES, metrics_of
from source_tree import ROOT

from recording import FOLDER
from recording.bag import opened
from swarm_msgs_py.messages.report import Mode

LAUNCHER = ROOT / "scripts" / "launch_swarm.py"
RUN_S, STOP_S = 120.0, 3.0  # deadlines; only STOP_S is a promise
DUE = {
    *("scenario", "family", "method", "seed", "engine", "physics", "robots", "achieved", "reason", "ticks"),
    *("sim_time_s", "wall_time_s", "real_time_factor", "startup_s", "total_displacement_m"),
    *("displacement_lower_bound_m", "settling_time_s", "collisions", "min_clearance_m", "localization_rmse_m"),
    *("localization_max_m", "radio_frames", "radio_bytes", "radio_peak_bps", "lost_robots", "mesh_topological"),
    "radio_neighborhood_peak_bps",
    *("mesh_geometrical", "goals_reached"),
}
"""What the metrics of a formation always have, and in a run that achieved its shape always with a value."""

Launch = Callable[..., "subprocess.Popen[str]"]

pytestmark = pytest.mark.needs_ros


@pytest.fixture
def launch(domain_id: int, tmp_path: Path) -> Iterator[Launch]:
    """Start launchers in sessions and a domain of their own; fail if anything of them is left at the end."""
    temporary, started = tmp_path / "tmp", []
    temporary.mkdir()
    before = shared_memory()

    def start(*options: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, str(LAUNCHER), *options],
            cwd=tmp_path,
            env=os.environ | {"TMPDIR": str(temporary), "ROS_DOMAIN_ID": str(domain_id)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        started.append(process)
        return process

    try:
        yield start
        for process in started:
            assert wait_until(lambda group=process.pid: not session_members(group))
        assert [path.name for path in temporary.iterdir()] == []
        assert orphaned(shared_memory() - before) == set()
    finally:
        for process in started:
            for member in session_members(process.pid):
                os.kill(member, signal.SIGKILL)
            process.wait()


def read_until(process: subprocess.Popen[str], text: str) -> str:
    """Return what a process prints up to a line with `text`."""
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        lines.append(line)
        if text in line:
            return "".join(lines)
    pytest.fail(f"'{text}' was not printed:\n{''.join(lines)}")


def test_a_swarm_of_ros_nodes_forms_its_shape_and_leaves_nothing_but_its_results(
    launch: Launch, tmp_path: Path
) -> None:
    process = launch("--engine", "ros", "--scenario", "smoke-4", "--record", "--out", "run")
    output, _ = process.communicate(timeout=RUN_S)

    assert process.returncode == 0, output
    assert "shape formed" in output
    assert "ALERT" not in output
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == sorted([*FILES, FOLDER])
    recorded = re.search(r"recording: (\d+) messages on \d+ topics, none lost", output)
    assert recorded is not None, output
    with opened(tmp_path / "run") as bag:
        assert sum(topic.count for topic in bag.topics) == int(recorded[1])
    metrics = metrics_of(tmp_path / "run")
    assert (metrics["engine"], metrics["physics"], metrics["achieved"]) == ("ros", "bullet", True)
    assert (metrics["collisions"], metrics["lost_robots"], metrics["robots"]) == (0, 0, 4)
    assert all(metrics[name] is not None for name in DUE)
    assert metrics["startup_s"] > 0.0
    assert metrics["radio_frames"] > metrics["ticks"]


@pytest.mark.parametrize(
    ("method", "event", "duration_s"),
    [
        ("bubble-packing", "{at_s: 18.0, kill: [5]}", 20),
        ("voronoi", "{at_s: 2.0, stop: mission_computer}", 12),
        ("forces", "{at_s: 2.0, stop: mission_computer}", 12),
    ],
)
def test_ros_and_in_process_runs_are_the_same_byte_for_byte(
    launch: Launch, tmp_path: Path, method: str, event: str, duration_s: int
) -> None:
    settings = ("--set", f"events=[{event}]", "--set", f"duration_s={duration_s}")
    scenario = ("--scenario", "demo", "--seed", "3", "--method", method, *settings)  # three types, walls, PyBullet
    for engine in ("inprocess", "ros"):
        process = launch("--engine", engine, *scenario, "--out", engine)
        output, _ = process.communicate(timeout=RUN_S)
        assert process.returncode == 1, output  # the time is up before the shape is formed
        assert f"time limit of {duration_s} s" in output

    ours, theirs = (np.load(tmp_path / engine / "trajectories.npz") for engine in ("ros", "inprocess"))
    assert ours.files == theirs.files
    for name in ours.files:
        assert ours[name].dtype == theirs[name].dtype, name
        assert ours[name].tobytes() == theirs[name].tobytes(), name
    positions = next(ours[name] for name in ours.files if "position" in name)
    assert np.ptp(positions, axis=0).max() > 1.0
    assert ours["mode"][-1].max() >= Mode.TRAVELING
    told, wanted = (metrics_of(tmp_path / engine) for engine in ("ros", "inprocess"))
    timing = {"engine", "wall_time_s", "real_time_factor", "startup_s"}
    assert {k: v for k, v in told.items() if k not in timing} == {k: v for k, v in wanted.items() if k not in timing}


def test_an_interrupted_ros_run_ends_in_time_with_code_130_and_keeps_its_results(
    launch: Launch, tmp_path: Path
) -> None:
    process = launch("--engine", "ros", "--scenario", "smoke-4", "--real-time", "--record", "--out", "run")
    read_until(process, "at their goals")
    os.killpg(process.pid, signal.SIGINT)  # as Ctrl-C does: everybody in the foreground gets it
    began = time.monotonic()
    output, _ = process.communicate(timeout=RUN_S)

    assert time.monotonic() - began < STOP_S
    assert process.returncode == 130, output
    assert "Traceback" not in output
    assert "interrupted by the operator" in output
    assert metrics_of(tmp_path / "run")["ticks"] >= 1
    assert (tmp_path / "run" / "trajectories.npz").stat().st_size > 0
    with opened(tmp_path / "run") as bag:
        assert len(bag.topics) > 40


def test_a_killed_process_of_agents_is_named_with_its_robots_and_the_run_ends_by_itself(
    launch: Launch, tmp_path: Path
) -> None:
    process = launch(
        "--engine", "ros", "--scenario", "demo", "--agents-per-process", "4", "--set", "duration_s=40", "--out", "run"
    )
    read_until(process, "at their goals")
    *_, last = children_of(process.pid)
    os.kill(last, signal.SIGKILL)
    output, _ = process.communicate(timeout=RUN_S)

    assert process.returncode in {0, 1}, output
    assert re.search(rf"ALERT  r02, r05, r08, r11 \(process {last}\) died: signal 9 \(SIGKILL\)\n", output)
    metrics = metrics_of(tmp_path / "run")
    assert metrics["lost_robots"] == 4
    assert "interrupted" not in metrics["reason"]
    assert metrics["sim_time_s"] > 20.0
    assert metrics["collisions"] is not None
