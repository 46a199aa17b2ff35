"""What a camera can know a robot by: two discs of one color on its cover, and the marks of the arena's floor.

The thesis (section 5.1) gives the colors and that one disc is larger than the other; sizes and places are a decision of
this project, where the thesis is silent (spec section 15.2, erratum E37).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from swarm_msgs_py.types import FloatArray, NodeId

LARGE_RADIUS_SHARE, LARGE_PLACE_SHARE = 0.42, -0.40
SMALL_RADIUS_SHARE, SMALL_PLACE_SHARE = 0.22, 0.62
"""Radius of a disc, and its place along the heading from the middle of the cover, as shares of the cover's radius."""
COVER_HEIGHT_M = 0.12
"""Height of the covers above the floor [m], unless a marker says otherwise."""


class MarkerColor(Enum):
    """Color of the discs of one robot (thesis table 5.1)."""

    RED = "red"
    BLUE = "blue"
    GREEN = "green"
    YELLOW = "yellow"
    PINK = "pink"


PRINTED_SRGB = {
    MarkerColor.RED: (205, 35, 30),
    MarkerColor.BLUE: (35, 80, 205),
    MarkerColor.GREEN: (25, 150, 65),
    MarkerColor.YELLOW: (230, 200, 35),
    MarkerColor.PINK: (235, 105, 175),
}
"""What the discs are printed with: sRGB codes, 0 to 255. Hues are at least 45 degrees apart in CIELAB."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverMarker:
    """The cover of one robot.

    Attributes
    ----------
    robot : NodeId
    color : MarkerColor
    radius : float
        Of the cover, which is the robot's coverage radius [m].
    height : float
        Of the cover above the floor [m].
    """

    robot: NodeId
    color: MarkerColor
    radius: float
    height: float = COVER_HEIGHT_M

    @property
    def large_radius(self) -> float:
        """Return the radius of the large disc [m]."""
        return LARGE_RADIUS_SHARE * self.radius

    @property
    def small_radius(self) -> float:
        """Return the radius of the small disc [m]."""
        return SMALL_RADIUS_SHARE * self.radius

    @property
    def large_place(self) -> float:
        """Return where the middle of the large disc is, along the heading from the middle of the cover [m]."""
        return LARGE_PLACE_SHARE * self.radius

    @property
    def small_place(self) -> float:
        """Return where the middle of the small disc is, along the heading from the middle of the cover [m]."""
        return SMALL_PLACE_SHARE * self.radius

    @property
    def baseline(self) -> float:
        """Return the distance between the middles of the two discs [m]."""
        return self.small_place - self.large_place


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorMarks:
    """Four black discs on the floor, one outside each corner of the arena, which tell a camera where it is.

    Attributes
    ----------
    half_width : float
        Of the square that their middles span, about the origin [m].
    radius : float
        Of each disc [m].
    """

    half_width: float = 1.05
    radius: float = 0.03

    @property
    def centers(self) -> FloatArray:
        """Return the middles (4, 2), counter-clockwise from (-, -), world frame [m]."""
        return self.half_width * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
