"""Composition root: turns a scenario into running actors, and a run into a folder of results."""
