"""Frozen records that travel between actors, one file per topic of conversation."""
