"""Lets the tests of this folder import what lies in ``benchmarks/``."""

from __future__ import annotations

import sys

from source_tree import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))
