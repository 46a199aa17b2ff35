"""The folder of a campaign: results line by line, then tables and figures as whole files."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from studies.campaign import ResultFile
from studies.code_version import code_version
from swarm_msgs_py.errors import ConfigError, SwarmError

RESULTS = "results.jsonl"


def read_results(out: Path) -> ResultFile:
    """Return the results in a folder, which may be missing; nothing is made.

    Raises
    ------
    ConfigError
        If they cannot be read.
    """
    return ResultFile(out / RESULTS, code_version())


def open_results(out: Path) -> ResultFile:
    """Return the file of results in a folder, which is made if it is missing.

    Raises
    ------
    ConfigError
        If the folder cannot be written to.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        if not os.access(out, os.W_OK):
            raise PermissionError(0, "no permission")
    except OSError as error:
        raise ConfigError(f"--out {out}: cannot be written ({error.strerror}); give another folder") from None
    return read_results(out)


@contextmanager
def locked(out: Path) -> Iterator[None]:
    """Keep other campaigns from writing to a folder's file of results; however this process ends, the lock ends too.

    Raises
    ------
    ConfigError
        If another process holds the lock, or the file cannot be opened.
    """
    path = out / RESULTS
    try:
        file = path.open("a", encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror}); give another --out") from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ConfigError(
                f"--out {out}: another process is writing results there; wait for it, or give another folder"
            ) from None
        yield


def write_files(out: Path, contents: Mapping[str, bytes | None]) -> None:
    """Write tables and figures; whoever looks sees whole files. What is None is left out.

    Raises
    ------
    SwarmError
        If the disk does not take them.
    """
    try:
        for name, data in contents.items():
            if data is not None:
                draft = out / f".{name}.part"
                draft.write_bytes(data)
                os.replace(draft, out / name)
    except OSError as error:
        raise SwarmError(f"{out}: tables could not be written ({error.strerror})") from None
