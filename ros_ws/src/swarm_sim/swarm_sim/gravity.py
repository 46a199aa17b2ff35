"""How strongly the ground pulls."""

from __future__ import annotations

GRAVITY = 9.81
"""Acceleration [m/s^2]."""
