"""One robot of the swarm: localise, route, decide, control."""
