"""Point robots in space: the world of the coverage family."""
