"""The mission computer: shape in, goals out."""
