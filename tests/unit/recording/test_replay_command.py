"""The command line of replay.py, without ROS."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from recording import FOLDER
from recording.bag import BagWriter
from recording.replay_cli import main
from swarm_msgs_py.ros import cdr
from swarm_msgs_py.topics import channels_by_topic
from swarm_msgs_py.types import NodeId


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Return a run folder with a recording of nothing but the clock."""
    writer = BagWriter(tmp_path / FOLDER, channels_by_topic((NodeId(0),)))
    writer.write("/clock", 0.0, cdr.stamp(0.0))
    writer.close()
    return tmp_path


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["nowhere"], r"nowhere: there is no such file or folder; name a run folder"),
        (["RUN", "--topic", "/r07/"], r"--topic /r07/: the recording has no such topic; it has /clock"),
        (["RUN", "--rate", "fast"], r"--rate: expected a number from 0 to 10000, got 'fast'"),
        (["RUN", "--start", "5"], r"--start 5: the recording ends after 0 s; begin earlier"),
        (["RUN", "--looop"], r"--looop: unknown option"),
        ([], r"the following arguments are required: BAG"),
    ],
)
def test_bad_input_is_one_line_and_code_2(
    words: list[str], complaint: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(run) if word == "RUN" else word for word in words]) == 2

    error = capsys.readouterr().err
    assert re.search(complaint, error)
    assert error.count("\n") == 1
