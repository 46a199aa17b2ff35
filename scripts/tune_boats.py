#!/usr/bin/env python3
"""Find the gains of the boats' controllers: ``scripts/tune_boats.py --help``."""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from studies.boat_tuning import main

    sys.exit(main())
