"""Truth: bodies, ground, obstacles."""
