"""Methods of one's own, added to the swarm by entry points."""
