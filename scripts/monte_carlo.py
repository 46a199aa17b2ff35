#!/usr/bin/env python3
"""Compare methods over many random starts: ``scripts/monte_carlo.py --help``."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is started yet; a traceback out of an import helps nobody
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from batches.cli import main

    sys.exit(main())
