"""What tests ask of a finished run's folder."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

from bringup.cli import main

FILES = ["figure.png", "metrics.json", "report.html", "scenario.yaml", "trajectories.npz"]
FAST = ("--engine", "inprocess", "--physics", "massdamper")
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def run_in_process(out: Path, *options: str) -> int:
    """Run the command line in this process, without ROS and PyBullet; return its exit code."""
    return main([*FAST, "--out", str(out), *options])


def metrics_of(folder: Path) -> dict[str, Any]:
    metrics: dict[str, Any] = json.loads((folder / "metrics.json").read_text())
    return metrics


def png_size(path: Path) -> tuple[int, int]:
    """Return width and height of a PNG file [px], from its header."""
    data = path.read_bytes()
    assert data.startswith(PNG_SIGNATURE)
    width, height = struct.unpack(">II", data[16:24])
    return width, height
