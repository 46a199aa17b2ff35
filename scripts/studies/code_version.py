"""Which code made a number: results of different code must not be averaged without a word."""

from __future__ import annotations

import hashlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("ros_ws/src", "scripts")
DIGITS = 12


def code_version(root: Path = ROOT) -> str:
    """Return a fingerprint of all Python source that a simulated run may depend on."""
    digest = hashlib.sha256()
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.py")):
            digest.update(f"{path.relative_to(root)}\0".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:DIGITS]
