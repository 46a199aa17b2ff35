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


if __name__ == "__main__":
    signal.signal(signal.SIGINT, _leave)
    signal.signal(signal.SIGTERM, _leave)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # under nohup it is to stay ignored
        signal.signal(signal.SIGHUP, _leave)
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from bringup.cli import main

    sys.exit(main())
