"""Making way: a robot at rest moves aside for one that cannot get past.

Avoidance alone cannot free a robot that is shut in by parked ones, since those do not want to move. A blocked robot
says so in its hello frames (`Presence.asks_for_way`); robots near it that have nothing better to do step back, and
return afterwards.
"""

from __future__ import annotations

import numpy as np

from swarm_agent.control.config import YieldingConfig
from swarm_msgs_py.types import FloatArray

_ASIDE = np.array([[1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(2.0)
"""Turns a vector by 45 degrees to the right, so that the blocked robot is not merely pushed back along its way."""

_ON_ITS_WAY = 1.5
"""A robot farther from its goal than this many of its farthest steps aside is not there yet: it has a way to go."""


def make_way(
    position: FloatArray, destination: FloatArray, blocked: FloatArray, config: YieldingConfig
) -> FloatArray | None:
    """Return the velocity with which to make way; None when nobody near is blocked, or the robot is still on its way.

    Parameters
    ----------
    position, destination : (2,) array
        Own estimate and own goal [m].
    blocked : (n, 2) array
        Positions that blocked neighbors have told of themselves [m].
    config : YieldingConfig

    Returns
    -------
    (2,) array or None
        Velocity, world frame [m/s]; zero when the robot has stepped aside as far as it may.
    """
    away = float(np.hypot(*(position - destination)))
    if not len(blocked) or away > _ON_ITS_WAY * config.displacement_max_m:
        return None
    offsets = position - blocked
    distances = np.hypot(offsets[:, 0], offsets[:, 1])
    nearest = int(distances.argmin())
    if distances[nearest] >= config.distance_m or distances[nearest] == 0.0:
        return None
    if away > config.displacement_max_m:
        return np.zeros(2)
    velocity: FloatArray = _ASIDE @ (offsets[nearest] / distances[nearest]) * config.speed_m_s
    return velocity
