"""Which goal is for which type of robot, so that the robots have less far to go.

A packing of even centers is as good a formation whichever of its places the large robots take, as long as they fit
there. The thesis lets the packing decide, which knows nothing of where robots are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from mission_computer.membership import Member
from swarm_msgs_py.partition import GoalSet
from swarm_msgs_py.types import FloatArray, IntArray


def nearest_types(goals: GoalSet, members: Sequence[Member]) -> IntArray | None:
    """Return the type of each goal, (n,), with which the beelines of all robots together are shortest.

    Parameters
    ----------
    goals : GoalSet
    members : sequence of Member
        The robots that the goals are for.

    Returns
    -------
    array or None
        None if the goals are not for these robots, or it is not known where all of them are.
    """
    places = [member.position for member in members if member.position is not None]
    types = np.array([member.type for member in members], dtype=np.int64)
    if len(places) < len(members) or not np.array_equal(np.sort(types), np.sort(goals.types)):
        return None
    robots, taken = linear_sum_assignment(_beelines(np.array(places), goals.positions))
    nearest = np.empty_like(goals.types)
    nearest[taken] = types[robots]
    return nearest


def distance_to_go(goals: GoalSet, members: Sequence[Member]) -> float:
    """Return how far robots, all of whose places are known, drive at least to goals for their types [m]."""
    total = 0.0
    for kind in np.unique(goals.types):
        places = [member.position for member in members if member.type == kind and member.position is not None]
        lengths = _beelines(np.array(places).reshape(-1, 2), goals.positions[goals.types == kind])
        total += float(lengths[linear_sum_assignment(lengths)].sum())
    return total


def _beelines(places: FloatArray, goals: FloatArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(places[:, None] - goals[None], axis=2)
    return lengths
