"""Monte Carlo batches that are done in a second, and what they leave."""

from __future__ import annotations

import json
from pathlib import Path

from source_tree import ROOT

from batches.cli import main
from studies.campaign_folder import RESULTS

SCRIPT = ROOT / "scripts" / "monte_carlo.py"
METHODS = ["--method", "bubble-packing", "fractals"]
SMALL = ["--scenario", "smoke-4", *METHODS]
DEADLINE_S = 120.0


def batch(out: Path, *options: str) -> int:
    return main([*SMALL, *options, "--out", str(out)])


def entries(out: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (out / RESULTS).read_text().splitlines()]


def metrics_of(out: Path) -> dict[str, bytes]:
    """Return the metrics of each run as bytes, without what a clock says."""
    found = {str(entry["run"]): json.dumps(entry["result"]["metrics"]).encode() for entry in entries(out)}  # type: ignore[index]
    assert len(found) == len(entries(out))  # no run was made twice
    return found
