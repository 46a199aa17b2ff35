"""What a force law is: forces on robots at given places, among others at given places."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
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


@dataclass(frozen=True, eq=False)
class Offsets:
    """Where others are, as n robots see them.

    Attributes
    ----------
    positions, radii
        Of the n robots that react, (n, 2) and (n,) [m].
    others : Others
    """

    positions: FloatArray
    radii: FloatArray
    others: Others

    @cached_property
    def x(self) -> FloatArray:
        """From each other robot to each that reacts, east, (n, m) [m]."""
        x: FloatArray = self.positions[:, :1] - self.others.positions[:, 0]
        return x

    @cached_property
    def y(self) -> FloatArray:
        """From each other robot to each that reacts, north, (n, m) [m]."""
        y: FloatArray = self.positions[:, 1:] - self.others.positions[:, 1]
        return y

    @cached_property
    def distances(self) -> FloatArray:
        """Between centers, (n, m) [m]."""
        distances: FloatArray = np.sqrt(self.x * self.x + self.y * self.y)
        return distances

    @cached_property
    def gaps(self) -> FloatArray:
        """Between coverage circles, negative where they overlap, (n, m) [m]."""
        gaps: FloatArray = self.distances - self.radii[:, None] - self.others.radii
        return gaps

    def push(self, strengths: FloatArray) -> FloatArray:
        """Return the sum of forces of given (n, m) strengths away from those who were heard, (n, 2).

        Two robots at one point push each other nowhere.
        """
        weights = np.where(self.others.heard, strengths, 0.0) / np.maximum(self.distances, _TINY)
        return np.stack([np.einsum("nm,nm->n", weights, self.x), np.einsum("nm,nm->n", weights, self.y)], axis=1)


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
