#!/usr/bin/env python3
"""Run a swarm: ``scripts/launch_swarm.py --help``."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from types import FrameType

INTERRUPTED = 130


def _leave(number: int, frame: FrameType | None) -> None:  # noqa: ARG001 - the shape of a signal handler
    # Nothing is started or written yet; an exception in the middle of the imports could be taken for a broken library.
    os._exit(INTERRUPTED)


def _open_what_is_closed() -> None:
    """Give descriptors 0 to 2 that the caller has closed to the null device.

    Else a socket of the run could get one of these numbers, and what C code prints would go into it.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8", closefd=False)


if __name__ == "__main__":
    _open_what_is_closed()
    signal.signal(signal.SIGINT, _leave)
    signal.signal(signal.SIGTERM, _leave)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # under nohup it is to stay ignored
        signal.signal(signal.SIGHUP, _leave)
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from bringup.cli import main

    sys.exit(main())
