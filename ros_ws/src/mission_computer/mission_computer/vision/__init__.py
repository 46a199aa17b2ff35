"""Overhead images -> where robots are: calibration, colors, discs, covers."""
