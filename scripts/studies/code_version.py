"""Which code made a number: results of different code must not be averaged without a word."""

from __future__ import annotations

import hashlib
import importlib.util
from collections.abc import Iterator, Sequence
from pathlib import Path

from swarm_msgs_py.extensions import extension_points

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
    """Return a fingerprint of all source and data that a simulated run may depend on, installed extensions included.

    Parameters
    ----------
    root : Path
        Of the project.
    folders : sequence of str
        Below it, whose files count.
    """
    digest = hashlib.sha256()
    for folder in folders:
        for path in _sources(root / folder):
            name = path.relative_to(root).as_posix()
            if path.name not in GENERATED and name not in REPORTING:
                _take(digest, name, path)
    for point in extension_points():
        version = point.dist.version if point.dist is not None else ""
        digest.update(f"{point.group} {point.name} {point.value} {version}\0".encode())
        package = point.module.partition(".")[0]
        for place in _places(package):
            for path in _sources(place):
                _take(digest, f"{package}/{path.relative_to(place).as_posix()}", path)
    return digest.hexdigest()[:DIGITS]


def _take(digest: hashlib._Hash, name: str, path: Path) -> None:
    digest.update(f"{name}\0".encode())
    digest.update(path.read_bytes())


def _sources(place: Path) -> Iterator[Path]:
    """Yield the files that count in a folder, or a file that is a module of its own, in a fixed order."""
    if place.is_file():
        yield place
    yield from (path for path in sorted(place.rglob("*")) if path.suffix in KINDS and path.is_file())


def _places(package: str) -> list[Path]:
    """Return the folders of an installed package, or the file of a module, also if it is installed to be edited."""
    spec = importlib.util.find_spec(package)  # of a whole package: imports nothing
    if spec is None:
        return []
    if spec.submodule_search_locations is not None:
        return [Path(place) for place in spec.submodule_search_locations]
    return [Path(spec.origin)] if spec.origin else []
