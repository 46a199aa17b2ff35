"""Shared vocabulary of the swarm: all that two packages must agree on."""
