"""The commands that the documents tell people to type, and how each of them is tried."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

from source_tree import ROOT, SRC

LAUNCHER = "scripts/launch_swarm.py"
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
_SHELLS = ("bash", "sh", "console")

TRIED = {
    LAUNCHER: "run, shortened: system/test_documentation.py",
    "scripts/shape.py": "run: system/test_documentation.py",
    "scripts/monte_carlo.py": "run, shortened: system/test_documentation.py",
    "scripts/plot_run.py": "run: system/test_viewing_commands.py",
    "scripts/replay.py": "run: system/test_viewing_commands.py",
    "scripts/order.py": "run, on a swarm: ros/test_documented_orders.py",
    "scripts/coverage_study.py": "read; run with one seed: unit/studies/test_coverage_experiments.py",
    "scripts/lps_study.py": "read; run with 14 robots: system/test_lps_study.py",
    "scripts/camera_study.py": "read; run with few images: unit/studies/test_camera_study.py",
    "scripts/tracking_study.py": "read; run on one curve: unit/studies/test_tracking_study.py",
    "scripts/tune_boats.py": "read; what it calls: unit/swarm_sim",
    "benchmarks/": "read; each run as small as it gets: unit/benchmarks/test_benchmark_mains.py",
    "pip install": "run: system/test_own_methods_example.py",
    "ros2 launch": "arguments compared with the launch files: ros/test_documented_orders.py",
    "ros2 run": "its node made with these parameters: ros/test_documented_orders.py",
    "ros2 topic": "topic, type and message made: ros/test_documented_orders.py",
    "ros2 service": "service, type and request made: ros/test_documented_orders.py",
    "ros2 node": "of ROS itself",
    "ros2 param": "of ROS itself",
    "ros2 bag": "of ROS itself; what it plays is read back: ros/test_recording.py",
    "rviz2": "its file: ros/test_swarm_bringup.py",
    "make": "target looked up: test_project_files.py; `make run` is run as the launcher",
    "git clone": "not run",
    "source": "not run",
    "export": "not run",
}
"""What starts a command -> how it is tried.

All commands of this project's scripts are read by test_project_files.py, too: their options and settings must exist.
Measurements take hours, so they are not run as they stand.
"""


def documents() -> list[Path]:
    """Return the Markdown files that people read."""
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *SRC.glob("*/README.md")])


def blocks(*languages: str) -> Iterator[tuple[Path, str]]:
    """Yield the fenced blocks of all documents in some languages, each with its document."""
    for path in documents():
        for language, text in _BLOCK.findall(path.read_text("utf-8")):
            if language in languages:
                yield path, text


def shell_commands() -> list[list[str]]:
    """Return the commands in the shell blocks of all documents, as words."""
    lines = [line for _, text in blocks(*_SHELLS) for line in text.replace("\\\n", " ").splitlines()]
    return [words for line in lines if (words := shlex.split(line, comments=True))]


def inline_spans() -> list[str]:
    """Return what stands between backticks in running text."""
    texts = [_BLOCK.sub("", path.read_text("utf-8")) for path in documents()]
    return [span for text in texts for span in re.findall(r"`([^`]+)`", text)]


def commands(script: str) -> list[tuple[str, ...]]:
    """Return what follows a script in shell blocks and running text, each different one once.

    A script that is only named in running text is not a command.
    """
    inline = [shlex.split(span) for span in inline_spans() if f"{script} " in span]
    found: dict[tuple[str, ...], None] = {}
    for words in [*shell_commands(), *inline]:
        if script == LAUNCHER and words[:2] == ["make", "run"]:
            handed = [word.partition("=")[2] for word in words[2:]]
            found[tuple(part for text in handed for part in shlex.split(text))] = None
        elif script in words:
            found[tuple(words[words.index(script) + 1 :])] = None
    return list(found)


def starting_with(*words: str) -> list[tuple[str, ...]]:
    """Return the commands in shell blocks and running text that begin with these words, whole, each once."""
    found = [*shell_commands(), *(shlex.split(span) for span in inline_spans() if span.startswith(words[0]))]
    complete = [tuple(each) for each in found if tuple(each[: len(words)]) == words and len(each) > len(words) + 1]
    return list(dict.fromkeys(complete))


def how_tried(words: list[str]) -> str | None:
    """Return how a command is tried; None: nobody has said so."""
    text = " ".join(words)
    for start, how in TRIED.items():
        is_script = start.startswith(("scripts/", "benchmarks/"))
        if any(word.startswith(start) for word in words) if is_script else f" {text} ".find(f" {start} ") >= 0:
            return how
    return None


def told(words: tuple[str, ...]) -> str:
    """Return a command as a person would read it."""
    return " ".join(words) or "(none)"
