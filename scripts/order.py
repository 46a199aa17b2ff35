#!/usr/bin/env python3
"""Give orders to a swarm that runs over ROS: ``scripts/order.py --help``."""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parent))

    from orders.order_cli import main

    sys.exit(main())
