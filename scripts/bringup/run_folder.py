"""The folder that receives a run's results: checked before the start, written file by file, never half."""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

from bringup.family import AnyScenario
from swarm_msgs_py.errors import ConfigError

ATTEMPTS = 100  # default folders that may start in one second with one scenario and seed


class RunFolder:
    """A folder of one run.

    Parameters
    ----------
    path : Path
        Made with its parents if missing; must be empty.

    Raises
    ------
    ConfigError
        If it is in use or cannot be written; then nothing was made.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._made: list[Path] = []
        try:
            for folder in reversed([folder for folder in (path, *path.parents) if not folder.exists()]):
                folder.mkdir()
                self._made.append(folder)
            if any(path.iterdir()):
                raise ConfigError(f"--out {path}: is not empty; give a new folder, or remove it first")
            with tempfile.TemporaryFile(dir=path):
                pass
        except OSError as error:
            self.release()
            raise ConfigError(
                f"--out {path}: cannot be written ({error.strerror}); give a folder that you may write to"
            ) from None

    def release(self) -> None:
        """Remove the folders that were made, as far as nothing was put into them."""
        for folder in reversed(self._made):
            try:
                folder.rmdir()
            except OSError:
                return
        self._made = []

    def write(self, name: str, data: bytes) -> Path:
        """Write one file; whoever looks sees the whole file or none. Returns its path."""
        target = self.path / name
        draft = self.path / f".{name}.part"
        try:
            draft.write_bytes(data)
            os.replace(draft, target)
        except OSError:
            draft.unlink(missing_ok=True)  # on a full disk it would hold the last space
            raise
        return target


def reserve_default(scenario: AnyScenario, parent: Path) -> RunFolder:
    """Return a new folder ``<time>-<scenario>-<seed>`` under `parent`.

    Raises
    ------
    ConfigError
        If it cannot be made.
    """
    stem = f"{time.strftime('%Y%m%d-%H%M%S')}-{scenario.name}-{scenario.seed}"
    names = (stem, *(f"{stem}-{number}" for number in range(2, ATTEMPTS)))
    path = next((parent / name for name in names if not (parent / name).exists()), parent / stem)
    return RunFolder(path)
