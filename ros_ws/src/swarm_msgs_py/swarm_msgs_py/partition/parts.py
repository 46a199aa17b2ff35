"""Shapes of several parts: which part has room for whom.

Partition methods let circles push each other along, and no circle passes a bridge between parts, so each part is a
problem of its own, with as many circles as its area has a share in the whole.
"""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Polygon

from swarm_msgs_py.geometry.bridges import BRIDGE_M
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.types import FloatArray, IntArray

SPECK = 1e-9  # share of the area; what rounding cuts off is no part


def parts_of(contour: FloatArray) -> tuple[FloatArray, ...]:
    """Return the contours of the parts that only bridges join; of a shape in one piece, the contour as it is.

    Parameters
    ----------
    contour : (k, 2) array
        Simple, counter-clockwise [m].
    """
    whole = Polygon(contour)
    pieces = shapely.get_parts(whole.buffer(-BRIDGE_M)).tolist()
    if len(pieces) < 2:
        return (contour,)
    grown = [piece.buffer(BRIDGE_M, join_style="mitre").intersection(whole) for piece in pieces]
    parts = [part for part in grown if isinstance(part, Polygon) and part.area > SPECK * whole.area]
    if len(parts) < len(pieces):
        return (contour,)
    return tuple(np.array(shapely.geometry.polygon.orient(part).exterior.coords)[:-1] for part in parts)


def shared_out(parts: tuple[FloatArray, ...], types: IntArray, room: IntArray) -> list[IntArray] | None:
    """Return who goes to which part: as many as its area has a share, of each type as evenly as it can be.

    Parameters
    ----------
    parts : tuple of (k, 2) array
        Contours [m].
    types : (n,) int array
        Type of each circle, all types spread over the sequence.
    room : (len(parts),) int array
        How many circles each part takes at most.

    Returns
    -------
    list of (m,) int array, or None
        Per part, the types of its circles; None if there is no room for all.
    """
    areas = np.array([signed_area(part) for part in parts])
    shares, counts = areas / areas.sum(), np.zeros(len(parts))
    owners = np.empty(len(types), dtype=np.int64)
    for number in range(len(types)):
        behind = np.where(counts < room, shares * (number + 1) - counts, -np.inf)
        owner = int(np.argmax(behind))  # whoever is farthest behind its share
        if counts[owner] >= room[owner]:
            return None
        owners[number] = owner
        counts[owner] += 1
    return [types[owners == part] for part in range(len(parts))]
