"""What a force law is: forces on robots at given places, among others at given places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from swarm_msgs_py.types import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Others:
    """The robots that others react to.

    Attributes
    ----------
    positions : (m, 2) array
        World frame [m].
    radii : (m,) array
        Coverage radii [m].
    heard : (n, m) array of bool
        Which of them each of the n robots that react has heard of; never itself.
    """

    positions: FloatArray
    radii: FloatArray
    heard: BoolArray

    @classmethod
    def each_other(cls, positions: FloatArray, radii: FloatArray) -> Others:
        """Return what n robots are to each other when everybody hears everybody."""
        return cls(positions, radii, ~np.eye(len(positions), dtype=np.bool_))


class Offsets:
    """Where others are, as n robots see them.

    Parameters
    ----------
    positions : (n, 2) array
        Of the robots that react [m].
    radii : (n,) array
        Their coverage radii [m].
    others : Others

    Attributes
    ----------
    ways : (2, n, m) array
        From each other robot to each that reacts, east and north [m].
    distances : (n, m) array
        Between centers [m].
    gaps : (n, m) array
        Between coverage circles, negative where they overlap [m].
    """

    def __init__(self, positions: FloatArray, radii: FloatArray, others: Others) -> None:
        self.ways: FloatArray = np.subtract(positions.T[:, :, None], others.positions.T[:, None], order="C")
        x, y = self.ways
        self.distances: FloatArray = np.sqrt(x * x + y * y)
        self.gaps: FloatArray = self.distances - radii[:, None] - others.radii
        self._heard = others.heard

    def push(self, strengths: FloatArray) -> FloatArray:
        """Return the sum of forces of given (n, m) strengths away from those who were heard, (n, 2).

        Two robots at one point push each other nowhere.
        """
        weights = np.where(self._heard, strengths, 0.0) / np.maximum(self.distances, _TINY)
        push: FloatArray = np.vecdot(self.ways, weights).T
        return push


_TINY = 1e-9  # [m]


class ForceLaw(Protocol):
    """Forces toward a formation, a function of places only: equal inputs give equal forces."""

    @property
    def step_max(self) -> float:
        """Longest time over which a robot may be moved by one evaluation [s]."""
        ...

    def evaluate(self, positions: FloatArray, radii: FloatArray, others: Others) -> FloatArray:
        """Return the force on each robot.

        Parameters
        ----------
        positions : (n, 2) array
            Robots that react, world frame [m].
        radii : (n,) array
            Their coverage radii [m].
        others : Others
            Whom they react to.

        Returns
        -------
        (n, 2) array
            Forces, in the units of the thesis' gains.
        """
        ...
