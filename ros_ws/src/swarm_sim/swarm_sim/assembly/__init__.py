"""Worlds for assembling boats."""
