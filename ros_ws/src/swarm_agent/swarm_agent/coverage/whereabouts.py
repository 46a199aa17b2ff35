"""Where a robot is, by those that it senses (Algorithm 2, step 2), and how it drives somewhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from swarm_agent.coverage.config import CoverageConfig, MotionConfig
from swarm_agent.coverage.frames import Key, Place
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.types import FloatArray, NodeId


@dataclass(frozen=True, slots=True, eq=False)
class Scale:
    """How large a formation is to be.

    Attributes
    ----------
    center : (3,) array
        What stays where it is [m].
    size : float
        1 at rest.
    """

    center: FloatArray
    size: float

    def placed(self, places: FloatArray) -> FloatArray:
        """Return where places (..., 3) of the layout [m] are now."""
        return self.center + self.size * (places - self.center)


def nearest_holder(around: Surroundings, held: Mapping[NodeId, Place]) -> tuple[NodeId, FloatArray] | None:
    """Return the nearest robot sensed that holds a place, and the offset to it (3,) [m]; None if there is none."""
    near = [(around.distances[row], robot, row) for robot, row in around.robots.items() if robot in held]
    if not near:
        return None
    _, robot, row = min(near)
    return robot, around.offsets[row]


def located(around: Surroundings, held: Mapping[NodeId, Place]) -> FloatArray | None:
    """Return the own position (3,) [m]: that of the nearest holder, less the offset to it; None without one."""
    nearest = nearest_holder(around, held)
    if nearest is None:
        return None
    robot, offset = nearest
    position: FloatArray = np.array(held[robot].position) - offset
    return position


def company(around: Surroundings, leader: NodeId, held: Mapping[NodeId, Place], link: float) -> FloatArray | None:
    """Return the offset to whom a robot without a place stays with, (3,) [m]; None if nobody is sensed.

    That is the leader, else the nearest robot at its place. Who senses neither has been left behind, alone or with
    others that were, and looks for those to whom it is not linked.

    Parameters
    ----------
    around : Surroundings
    leader : NodeId
    held : mapping
        Who holds which place.
    link : float
        Robots no farther apart are linked [m].
    """
    offset = around.offset(leader)
    if offset is not None:
        return offset
    nearest = nearest_holder(around, held)
    if nearest is not None:
        return nearest[1]
    far = np.flatnonzero(around.distances >= link)
    if not len(far):
        return None
    to_nearest: FloatArray = around.offsets[far[np.argmin(around.distances[far])]]
    return to_nearest


def farthest_off(target: FloatArray, around: Surroundings, held: Mapping[NodeId, Place], scale: Scale) -> float:
    """Return how far the own place is by that holder sensed by whom it is farthest [m]; 0 without one.

    Parameters
    ----------
    target : (3,) array
        The own place [m].
    around : Surroundings
    held : mapping
    scale : Scale
        Of the formation.
    """
    near = [(row, held[robot].position) for robot, row in around.robots.items() if robot in held]
    if not near:
        return 0.0
    rows, places = zip(*near, strict=True)
    offsets = target - scale.placed(np.array(places)) + around.offsets[list(rows)]
    return float(np.sqrt(np.einsum("ij,ij->i", offsets, offsets).max()))


def upstream(
    around: Surroundings, held: Mapping[NodeId, Place], hops: Mapping[Key, int], mine: Key, config: CoverageConfig
) -> list[tuple[NodeId, FloatArray]]:
    """Return holders that are nearer to the leader, by whom to keep station, and the offsets to them, (3,) each [m].

    It is the nearest one that is linked. Where robots at rest drift it is all that are sensed: each is off its place,
    their mean less, and whose link has broken still finds back.

    Parameters
    ----------
    around : Surroundings
    held : mapping
    hops : mapping
        Links to the leader, of places.
    mine : Key
        The own place.
    config : CoverageConfig
    """
    depth = hops.get(mine, len(held))
    near = sorted(
        (around.distances[row], robot, row)
        for robot, row in around.robots.items()
        if (config.motion.drifts or around.distances[row] < config.range_m)
        and (place := held.get(robot)) is not None
        and hops.get(place.key, depth) < depth
    )
    return [(robot, around.offsets[row]) for _, robot, row in (near if config.motion.drifts else near[:1])]


def toward(offset: FloatArray | None, motion: MotionConfig, period: float, near: float = 0.0) -> FloatArray:
    """Return the velocity that gets to `offset` (3,) [m] as fast as may be without overshoot (eq. (8) with [I5]).

    It is zero if there is nowhere to go, or for what is no farther than `near` [m].
    """
    if offset is None:
        return np.zeros(3)
    distance = float(np.sqrt(offset @ offset))
    if distance <= near:
        return np.zeros(3)
    velocity: FloatArray = offset * (min(motion.speed_mps, distance / period) / distance)
    return velocity
