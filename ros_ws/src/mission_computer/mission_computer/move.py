"""A motion of the shape, as it is ordered."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.geometry.morphing import smooth_step
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """Where the shape is to move to, and when.

    Attributes
    ----------
    target : (k, 2) array
        Contour at the end [m].
    begins, ticks : int
        First tick of the motion, and how many it takes.
    period_s : float
        Duration of a tick [s].
    rotation_rad : float
        By how much the shape turns on the way, counter-clockwise [rad].
    """

    target: FloatArray
    begins: int
    ticks: int
    period_s: float
    rotation_rad: float = 0.0

    @property
    def duration_s(self) -> float:
        """How long it takes [s]."""
        return self.ticks * self.period_s


def haste(plan: Plan, period_s: float, speed_max: float) -> str:
    """Return a line for the operator if goals move faster than robots drive, "" if they do not.

    Parameters
    ----------
    plan : Plan
    period_s : float
        Duration of a tick [s].
    speed_max : float
        How fast robots drive [m/s].
    """
    motion = plan.motion
    if motion is None or not motion.track.size:
        return ""
    interval = motion.ticks * period_s / (motion.knots - 1)
    fastest = float(np.linalg.norm(np.diff(motion.track, axis=0), axis=2).max()) / interval
    if fastest <= speed_max:
        return ""
    enough = math.ceil(motion.ticks * period_s * fastest / speed_max)
    return (
        f"goals of plan {plan.epoch} move at up to {fastest:.2f} m/s, robots drive at {speed_max:g} m/s and will lag; "
        f"they keep up over {enough} s"
    )


def rest_of(plan: Plan, tick: int, period_s: float) -> Move | None:
    """Return what is left of the motion of a plan at a tick; None if it is over by then, or there is none.

    A shape that has to stop and start again on its way gets the time to do so without moving faster than before.
    """
    motion = plan.motion
    if motion is None or tick >= motion.ends:
        return None
    if tick <= motion.begins:
        return Move(plan.contour, motion.begins, motion.ticks, period_s, motion.rotation_rad)
    ahead = 1.0 - smooth_step((tick - motion.begins) / motion.ticks)  # of the way
    ticks = max(motion.ends - tick, math.ceil(ahead * motion.ticks))
    return Move(plan.contour, tick, ticks, period_s, ahead * motion.rotation_rad)
