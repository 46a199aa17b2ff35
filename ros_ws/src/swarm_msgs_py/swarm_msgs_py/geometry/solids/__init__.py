"""Solid shapes in space: primitives, their combinations, prisms and meshes behind one vectorized inside test."""
