"""Everything that this project raises on purpose."""

from __future__ import annotations


class SwarmError(Exception):
    """Base of all errors of this project; its text is one line that a person can act on."""


class ConfigError(SwarmError):
    """A setting is unknown, of the wrong type or outside its range."""


class ShapeError(SwarmError):
    """A shape cannot be used: self-crossing, empty, or too small for the robots."""


class FrameError(SwarmError):
    """Bytes from the radio are not a frame of this version."""


class PhysicsError(SwarmError):
    """The physics back end is missing or refused a scene."""


class AssemblyError(SwarmError):
    """An assembly problem cannot be used: a wrong file, unconnected targets, too few boats, starts that touch."""


class NoDispatchError(AssemblyError):
    """No dispatch joins these boats to the wanted structure; the text says why, or how near the search came."""
