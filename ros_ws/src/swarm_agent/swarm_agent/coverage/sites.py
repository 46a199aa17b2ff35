"""What a robot knows when it chooses a place for the next one, and what it has chosen."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import FloatArray

REACH = 3.0  # in ranges: whose frontier, or coverage, a newcomer next to a robot may touch


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """What a robot knows of its surroundings when it chooses; everything relative to it [m].

    Attributes
    ----------
    own : (k, 3) array
        Its frontier points, k >= 1.
    around : (m, 3) array
        Frontier points of all robots within 3 r_sc, itself included.
    others : (j, 3) array
        Robots within 3 r_sc, itself included, and places that are reserved for robots.
    position : (3,) array
        Where it is, in the frame of the shape.
    solid : Solid
    """

    own: FloatArray
    around: FloatArray
    others: FloatArray
    position: FloatArray
    solid: Solid


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """A place for the next robot.

    Attributes
    ----------
    row : int
        Of the frontier point that it is for.
    place : (3,) array
        Relative to the robot that chooses [m].
    score : float
        How good it is, in spheres of frontier points; 0 where the rule does not ask.
    """

    row: int
    place: FloatArray
    score: float = 0.0
