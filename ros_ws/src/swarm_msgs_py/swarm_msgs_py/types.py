"""Basic types, with units and frames stated once.

SI units and radians everywhere. World frame: ENU (x right, y up on the map, yaw counter-clockwise from +x, REP 103).
Body frame: forward-left-up. Arrays are ``float64`` with one point per row.
"""

from __future__ import annotations

from typing import Final, NewType

import numpy as np
from numpy.typing import NDArray

NodeId = NewType("NodeId", int)
"""Address of one radio: a robot (0, 1, 2, ...) or the mission computer."""

MISSION: Final = NodeId(0xFFFE)
"""Address of the mission computer's radio."""

EVERYONE: Final = NodeId(0xFFFF)
"""Destination address of a flooded packet."""

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def robot_name(robot: NodeId) -> str:
    """Return the name, and namespace, of a robot: ``r07``."""
    return f"r{robot:02d}"


def node_name(node: NodeId) -> str:
    """Return what a node is called in messages to people: ``r07``, or ``mission computer``."""
    return "mission computer" if node == MISSION else robot_name(node)
