"""Where to set out for before it is known who takes which goal."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import FloatArray

AGREEMENT_MIN = 0.9
"""Least length of the mean of the unit vectors toward the goals: 1 if all lie in one direction, 0 if they are all
around. A meter driven along that mean brings a robot nearer to a goal by so much, on the average of the goals."""

_NEAREST_M = 1e-9


def early_destination(position: FloatArray, goals: FloatArray) -> FloatArray | None:
    """Return the goal to drive to until the assignment is known, None if that may be the wrong way.

    Cost rows need some seconds to get through the mesh. A robot far from the shape need not wait for them: whichever
    goal will be its own lies in about the same direction. (To drive to the nearest one, as spec 11.5 has it, leads a
    robot astray that is inside the shape, or beside a long one.)

    Parameters
    ----------
    position : (2,) array
        Own estimate [m].
    goals : (m, 2) array
        Goals of the robot's type [m].
    """
    if not len(goals):
        return None
    offsets = goals - position
    directions = offsets / np.maximum(np.linalg.norm(offsets, axis=1), _NEAREST_M)[:, None]
    mean = directions.mean(axis=0)
    if float(np.hypot(*mean)) < AGREEMENT_MIN:
        return None
    best: FloatArray = goals[int(np.argmax(directions @ mean))]
    return best
