"""Which code made a number: results of different code must not be averaged without a word."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("ros_ws/src", "scripts")
KINDS = frozenset({".py", ".yaml", ".yml", ".json"})
"""Suffixes of source, scenarios, shapes and maps."""
GENERATED = frozenset({"scenario.schema.json"})
"""Made from the source; no run reads them."""
REPORTING = frozenset(
    f"scripts/batches/{name}.py"
    for name in (
        *("arguments", "cli", "cluster", "comparison", "comparison_figure", "controls", "estimates", "folder_cells"),
        *("quantities", "runs_table", "tables"),
    )
)
"""Source that hands out runs and tells of them, without which each run would be the same."""
DIGITS = 12


def code_version(root: Path = ROOT, folders: Sequence[str] = FOLDERS) -> str:
    """Return a fingerprint of all source and data that a simulated run may depend on.

    Parameters
    ----------
    root : Path
        Of the project.
    folders : sequence of str
        Below it, whose files count.
    """
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted((root / folder).rglob("*")):
            name = path.relative_to(root).as_posix()
            if path.suffix in KINDS and path.name not in GENERATED and name not in REPORTING and path.is_file():
                digest.update(f"{name}\0".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:DIGITS]
