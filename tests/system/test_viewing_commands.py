"""What the documents tell people to type to look at runs and to play recordings does what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from documented_commands import commands, told
from recorded_runs import made_run
from source_tree import ROOT

from recording import FOLDER
from recording.bag import BagWriter
from reports import plot_cli
from swarm_msgs_py.messages.sensing import ImuSample
from swarm_msgs_py.ros import cdr, convert
from swarm_msgs_py.topics import channels_by_topic
from swarm_msgs_py.types import NodeId

PLOT, REPLAY = "scripts/plot_run.py", "scripts/replay.py"
SMALL = ("--fps", "2", "--width", "2", "--dpi", "50")  # a film in full size takes long


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a run folder of the name that the documents give it, beneath the working directory."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "RUN"
    folder.mkdir()
    (folder / "metrics.json").write_text('{"scenario": "made-up", "seed": 3, "achieved": true}')
    (folder / "scenario.yaml").write_text("name: made-up\n")
    np.savez(folder / "trajectories.npz", **made_run().arrays)  # type: ignore[arg-type]
    return folder


@pytest.mark.parametrize("words", commands(PLOT), ids=told)
def test_documented_commands_draw_what_they_name(words: tuple[str, ...], run: Path) -> None:
    is_film = any(word.endswith((".mp4", ".gif")) for word in words)

    assert plot_cli.main([*words, *(SMALL if is_film else ())]) == 0
    named = [Path(words[place + 1]) for place, word in enumerate(words) if word == "--out"]
    assert all(path.stat().st_size > 0 for path in named or [run / "overview.pdf"])


@pytest.mark.needs_ros
@pytest.mark.usefixtures("domain_id")
@pytest.mark.parametrize("words", commands(REPLAY), ids=told)
def test_documented_commands_play_recordings(words: tuple[str, ...], tmp_path: Path) -> None:
    recording = tmp_path / words[0] / FOLDER
    recording.parent.mkdir(parents=True)
    writer = BagWriter(recording, channels_by_topic((NodeId(7),)))
    for second in range(0, 100, 20):
        imu = convert.encode_imu(cdr.stamp(float(second)), "r07/base_link", ImuSample(np.zeros(2), 0.0, 0.0))
        writer.write("/r07/imu", float(second), imu)
        writer.write("/clock", float(second), cdr.stamp(float(second)))
    writer.close()
    start = float(words[words.index("--start") + 1]) if "--start" in words else 0.0

    command = [sys.executable, str(ROOT / REPLAY), *words, "--wait", "0", "--rate", "0"]
    played = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)

    assert played.returncode == 0, played.stderr
    left = sum(second >= start for second in range(0, 100, 20))
    assert f"{2 * left} messages played" in played.stdout


def test_the_documents_tell_how_to_do_both() -> None:
    assert len(commands(PLOT)) >= 5
    assert len(commands(REPLAY)) >= 2
