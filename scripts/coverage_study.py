#!/usr/bin/env python3
"""Run the coverage paper's experiments: ``scripts/coverage_study.py --help``."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is started yet; a traceback out of an import helps nobody
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from studies.coverage_experiments import main

    sys.exit(main())
