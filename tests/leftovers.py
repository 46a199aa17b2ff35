"""What a run must not leave behind: processes, temporary files, shared memory, ROS domains that stay taken."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")
DEADLINE_S = 3.0


def session_members(session: int) -> list[int]:
    """Return the living processes of a session, the kernel's group of all that a process started."""
    return [process for process in _processes() if _stat(process)[3:4] == [str(session)]]


def children_of(parent: int) -> list[int]:
    """Return the living child processes of a process, in the order in which they were started."""
    return sorted(
        (process for process in _processes() if _stat(process)[1:2] == [str(parent)]), key=lambda p: int(_stat(p)[19])
    )


def is_running(process: int) -> bool:
    """Return whether a process exists and has not ended."""
    return bool(_stat(process))


def wait_until(is_true: Callable[[], bool], deadline_s: float = DEADLINE_S) -> bool:
    """Return whether a condition comes true in time."""
    deadline = time.monotonic() + deadline_s
    while not is_true() and time.monotonic() < deadline:
        os.sched_yield()
    return is_true()


def shared_memory() -> set[str]:
    """Return the names of all files in shared memory."""
    return {path.name for path in SHARED_MEMORY.iterdir()}


def orphaned(names: set[str]) -> set[str]:
    """Return those of some files in shared memory that are there, and that no living process uses.

    Other swarms may run on the machine; what belongs to them is no leftover.
    """
    names = names & shared_memory()
    if not names:
        return set()
    used: set[str] = set()
    for process in _processes():
        used |= {name for name in names if name in _files_of(process)}
    return (names - used) & shared_memory()


def _files_of(process: int) -> str:
    folder, texts = Path("/proc") / str(process), []
    try:
        texts.append((folder / "maps").read_text())
        texts += [os.readlink(file) for file in (folder / "fd").iterdir()]
    except OSError:  # it has ended, or is not ours
        pass
    return "\n".join(texts)


def _processes() -> list[int]:
    return [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdecimal()]


def _stat(process: int) -> list[str]:
    """Return the fields of a process from its state on; none if it has ended."""
    try:
        fields = (Path("/proc") / str(process) / "stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []
    return fields if fields[0] not in {"Z", "X"} else []
