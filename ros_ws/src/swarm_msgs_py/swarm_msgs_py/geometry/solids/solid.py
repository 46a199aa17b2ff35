"""What a solid is, for everything that asks where it is."""

from __future__ import annotations

from typing import Protocol

from swarm_msgs_py.types import BoolArray, FloatArray


class Solid(Protocol):
    """A bounded, closed part of space, described well enough to tell inside from outside.

    One test serves every kind of shape: planning, sense spheres and metrics ask many points at once, and never how
    the shape is made. Volume, surface and nearest point follow from the test by sampling (`solids.sampling`).
    """

    @property
    def bounds(self) -> FloatArray:
        """Lower and upper corner of a box around the solid, (2, 3) [m]."""
        ...

    def contains(self, points: FloatArray) -> BoolArray:
        """Return which of `points` (n, 3) [m] are inside or on the surface, (n,)."""
        ...

    def __hash__(self) -> int:
        """Return what tells it from others, so that what follows from a shape need not be computed again."""
        ...
