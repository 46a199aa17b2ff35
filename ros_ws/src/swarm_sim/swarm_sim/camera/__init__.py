"""The overhead camera of the arena: true bodies -> images."""
