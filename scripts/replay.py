#!/usr/bin/env python3
"""Play a recording onto ROS topics: ``scripts/replay.py --help``."""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from recording.replay_cli import main

    sys.exit(main())
