"""The goals that a plan leaves for its receivers to find: every receiver of one plan finds the same ones."""

from __future__ import annotations

import zlib
from dataclasses import replace

import numpy as np
import shapely

from swarm_msgs_py.errors import ShapeError, SwarmError
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.messages.bodies import Plan, Task
from swarm_msgs_py.partition import PartitionConfig, partition
from swarm_msgs_py.types import FloatArray, IntArray

_CM_PER_M = 100.0
_CORNERS_MIN = 3
GEOMETRY_ERRORS = (SwarmError, ArithmeticError, LookupError, RuntimeError, ValueError, shapely.errors.ShapelyError)
"""What geometry raises on polygons that are none, as a forged plan may have them. Nothing else is expected of it."""


def completed(plan: Plan, config: PartitionConfig) -> Plan:
    """Return a plan with the goals that it leaves to be found; any other plan as it is.

    Goals follow from the plan as it was sent and from the tuning of the method alone, and are in whole centimeters. Per
    process they are computed once.

    Parameters
    ----------
    plan : Plan
        As decoded, so that all compute with the same numbers.
    config : PartitionConfig
        Gaps and tuning; the method is that of the plan.

    Raises
    ------
    ShapeError
        If the shape has no room for the roster, or is none.
    """
    if plan.task is not Task.PARTITION or plan.roster is None or plan.method is None:
        return plan
    if not is_contour(plan.contour):
        raise ShapeError("a contour that crosses itself, runs clockwise or encloses nothing cannot be partitioned")
    tuning = replace(config, method=plan.method)
    try:
        goals = partition(plan.contour, plan.roster, plan.walls, tuning, keep_outs=plan.body_outlines)
    except ShapeError:
        raise
    except GEOMETRY_ERRORS as error:
        raise ShapeError(f"cannot be partitioned ({type(error).__name__}: {error}); simplify it") from error
    places: FloatArray = np.rint(goals.positions * _CM_PER_M) / _CM_PER_M
    places.flags.writeable = False
    return replace(plan, goals=places, goal_types=goals.types)


def goals_crc(goals: FloatArray, types: IntArray) -> int:
    """Return the checksum of goals, in whole centimeters, and of their types; 0 for no goals."""
    if not len(goals):
        return 0
    centimeters = np.rint(goals * _CM_PER_M).astype("<i8")
    return zlib.crc32(types.astype("<i8").tobytes(), zlib.crc32(centimeters.tobytes()))


def is_contour(points: FloatArray) -> bool:
    """Return whether (k, 2) points are a simple contour, counter-clockwise, around some area."""
    if len(points) < _CORNERS_MIN or signed_area(points) <= 0.0:
        return False
    return bool(shapely.Polygon(points).is_valid)
