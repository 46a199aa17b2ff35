"""Where the benchmarks keep finished runs, so that a stopped one goes on where it was."""

from __future__ import annotations

from pathlib import Path

from studies.campaign import ResultFile
from studies.code_version import FOLDERS, code_version
from swarm_msgs_py.errors import ConfigError


def open_results(path: Path | None) -> ResultFile:
    """Return the file of results, whose folder is made if it is missing; None keeps nothing.

    Raises
    ------
    ConfigError
        If the folder cannot be made, or the file cannot be read.
    """
    if path is not None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ConfigError(f"--out {path}: cannot be written ({error.strerror}); give another file") from None
    return ResultFile(path, code_version(folders=(*FOLDERS, "benchmarks")))
