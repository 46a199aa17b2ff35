"""What the overhead camera says of this robot, out of all that the mesh brings."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.body_codec import decode_body
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.bodies import CameraFixes
from swarm_msgs_py.messages.radio import Delivery
from swarm_msgs_py.messages.sensing import PoseFix
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

AGE_TICKS_MAX = 20
"""A fix that is older than this is of no use: too much has happened since."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenFrom:
    """A fix that somebody else made.

    Attributes
    ----------
    tick : int
        When it was made.
    fix : PoseFix
    """

    tick: int
    fix: PoseFix


class Trail:
    """The steps of the last ticks, place or heading: what a fix that is some ticks old must be brought forward by.

    Parameters
    ----------
    ticks : int
        How many steps are kept.
    """

    def __init__(self, ticks: int) -> None:
        self._steps: deque[tuple[int, FloatArray]] = deque(maxlen=ticks)

    def note(self, tick: int, step: FloatArray) -> None:
        """Note the step (d,) by which a quantity changed up to a tick since the tick before."""
        self._steps.append((tick, step))

    def since(self, tick: int) -> FloatArray:
        """Return by how much it has changed since a tick, zero if nothing is known, (d,)."""
        steps = [step for when, step in self._steps if when > tick]
        return np.asarray(np.sum(steps, axis=0, initial=0.0))


class CameraFixReceiver:
    """Takes this robot's fixes from the mission computer's broadcasts; each image counts once, and none goes back.

    Parameters
    ----------
    robot : NodeId
        Whose fixes.
    """

    def __init__(self, robot: NodeId) -> None:
        self._robot = robot
        self.seen_at: int | None = None
        """Tick of the newest image that showed this robot."""

    def take(self, tick: int, deliveries: Sequence[Delivery]) -> SeenFrom | None:
        """Return the newest fix of this robot among what was delivered in a tick; None if there is none."""
        newest: SeenFrom | None = None
        for delivery in deliveries:
            if delivery.origin != MISSION:  # nobody else has a camera
                continue
            try:
                body = decode_body(delivery.body)
            except FrameError:
                continue
            if not isinstance(body, CameraFixes) or not tick - AGE_TICKS_MAX < body.tick <= tick:
                continue
            if self.seen_at is not None and body.tick <= self.seen_at:
                continue
            for fix in body.fixes:
                if fix.robot == self._robot:
                    self.seen_at, newest = body.tick, SeenFrom(body.tick, fix)
        return newest
