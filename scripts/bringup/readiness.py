"""Waits until every process of a run has said that it is ready."""

from __future__ import annotations

import time

from bringup.labels import first_few
from bringup.processes import ProcessGroup
from bringup.telemetry import Ready
from swarm_msgs_py.errors import SwarmError


def await_ready(group: ProcessGroup, deadline_s: float) -> None:
    """Return when all children have reported `Ready`.

    Parameters
    ----------
    group : ProcessGroup
    deadline_s : float
        Longest wait [s].

    Raises
    ------
    SwarmError
        If a child ends before, or the deadline passes; one line that names who is missing.
    """
    deadline = time.monotonic() + deadline_s
    waiting = list(group.children)
    while waiting:
        left = deadline - time.monotonic()
        if left <= 0.0:
            names = first_few([child.name for child in waiting])
            raise SwarmError(
                f"{len(waiting)} of {len(group.children)} processes were not ready within {deadline_s:g} s ({names}); "
                "use fewer processes (--agents-per-process), or see what they log"
            )
        for child, record in group.poll(left):
            if record is None:
                raise SwarmError(f"the swarm did not start: {child.epitaph()}")
            if isinstance(record, Ready):
                waiting.remove(child)
