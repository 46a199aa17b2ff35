"""How large a shape without a unit of length is to be: drawings, pictures and texts become as large as robots need."""

from __future__ import annotations

from dataclasses import replace

from mission_computer.shape.placement import Placement
from mission_computer.shape.source import ShapeSource, is_drawing, placed_shape
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.partition import PartitionConfig, needed_scale
from swarm_msgs_py.roster import Roster

ROOM_M2 = 6.0
"""Area per robot [m^2]; in the thesis, 50 are on 270 to 320 m^2."""

COMFORT = 1.1
"""By how much a shape is made larger than the smallest size that robots fit in."""


def with_room(
    source: ShapeSource, placement: Placement, roster: Roster, tuning: PartitionConfig, font: str | None = None
) -> Placement:
    """Return where a shape goes and how large it becomes; what has a unit of length stays as it is.

    Parameters
    ----------
    source : str, Path or points
    placement : Placement
        What is wanted. A drawing goes to the middle of the world unless this has a center, and becomes as large as the
        robots need unless this says how large.
    roster : Roster
        Who is to fit in.
    tuning : PartitionConfig
    font : str or None
        Of a text.

    Raises
    ------
    ShapeError
        One line that names the source, what is wrong and what to do.
    """
    if not is_drawing(source):
        return placement
    placed = replace(placement, center=placement.center or (0.0, 0.0))
    if placement.fit is not None or placement.area is not None:
        return placed
    area = ROOM_M2 * roster.size
    contour = placed_shape(source, Placement(area=area), font)
    factor = needed_scale(contour, roster, tuning)
    if factor is not None and factor > 1.0:
        area = signed_area(contour) * (COMFORT * factor) ** 2
    return replace(placed, area=area)
