#!/usr/bin/env python3
"""Preview a shape: ``scripts/shape.py --help``."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is started; a traceback out of an import helps nobody
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from previews.shape_cli import main

    sys.exit(main())
