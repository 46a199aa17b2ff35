"""Whether a process computes or waits, as Linux sees it."""

from __future__ import annotations

import os
from pathlib import Path

_RUNNABLE = "R"  # on a core, or in the queue for one; asleep, stopped and dead processes have other letters
_STATE, _USER_TICKS, _SYSTEM_TICKS = 0, 11, 12  # fields of /proc/PID/stat behind the command's closing parenthesis


def computing_s(pid: int) -> float | None:
    """Return the CPU time that a process has used so far [s] if it computes at this moment, else None.

    It computes if its first thread, which runs its nodes, could use a core now, whether it has one or not: so a process
    on a crowded machine computes, and one that sleeps, is stopped or is dead does not. Where there is no ``/proc``,
    nobody is known to compute.
    """
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()
    except OSError:
        return None
    if fields[_STATE] != _RUNNABLE:
        return None
    return (int(fields[_USER_TICKS]) + int(fields[_SYSTEM_TICKS])) / os.sysconf("SC_CLK_TCK")
