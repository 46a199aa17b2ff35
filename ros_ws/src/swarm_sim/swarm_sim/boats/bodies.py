"""The contract of a back end for floating bodies: wrenches in, poses out, pairs held together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import CELL_M

FACE_VECTORS = np.array([face.offset for face in Face], dtype=np.float64)
"""Direction of each side in the frame of a boat that is turned as at its start, (4, 2)."""


@dataclass(frozen=True, slots=True, order=True)
class Latch:
    """Two sides that hold each other.

    Attributes
    ----------
    boat, other : int
        Rows, the lower first.
    face, other_face : Face
    """

    boat: int
    other: int
    face: Face
    other_face: Face

    @property
    def turn(self) -> float:
        """Heading of the other boat relative to the first, so that the two sides look at each other [rad]."""
        x, y = self.face.offset
        u, v = self.other_face.offset
        return float(np.arctan2(-y, -x) - np.arctan2(v, u))

    @property
    def offset(self) -> FloatArray:
        """Place of the other boat in the frame of the first [m]."""
        return np.asarray(CELL_M * FACE_VECTORS[self.face])


class Bodies(Protocol):
    """Boats as rigid bodies; one implementation per physics back end."""

    poses: FloatArray
    """x, y [m] and heading [rad] of each boat, (n, 3)."""
    velocities: FloatArray
    """Their derivatives, (n, 3)."""

    def step(self, wrenches: FloatArray) -> None:
        """Advance by one control step under constant wrenches (n, 3) in the world frame [N], [N m].

        Drag and contacts are the back end's own.
        """
        ...

    def latch(self, latch: Latch) -> None:
        """Hold two boats together from now on; they are drawn into line."""
        ...

    def release(self, latch: Latch) -> None:
        """Let two boats go."""
        ...

    def torn(self) -> list[Latch]:
        """Return the latches that were pulled apart in the last step; the back end has let them go."""
        ...

    def close(self) -> None:
        """Free what the back end holds; may be called again."""
        ...
