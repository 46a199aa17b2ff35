"""Recordings of a live swarm: MCAP bags that are written, checked for losses, and played back."""

FOLDER = "recording"
"""Name of the bag in a run folder."""
