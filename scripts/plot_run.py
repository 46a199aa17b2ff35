#!/usr/bin/env python3
"""Figures, films and the report of a run folder: ``scripts/plot_run.py --help``."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is started; a traceback out of an import helps nobody
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from reports.plot_cli import main

    sys.exit(main())
