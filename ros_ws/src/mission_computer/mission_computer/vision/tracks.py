"""Where robots were seen last, and whether one that shows elsewhere is to be believed.

A look-alike of a robot that is hidden fits every test of a single image; but robots do not leap. So a cover beyond what
its robot can have driven is no fix, unless it goes on to show there: then somebody has carried the robot.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.types import FloatArray, NodeId

STOPS_WITHIN_S = 1.0
"""A robot without fixes stands still after this long [s]; its blobs are then no farther away."""


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where a robot was last.

    Attributes
    ----------
    position : (2,) array
        [m].
    reach : float
        How far it may be from there by now [m].
    """

    position: FloatArray
    reach: float

    def may_be_at(self, place: FloatArray, margin: float = 0.0) -> bool:
        """Return whether the robot may be within `margin` [m] of a place (2,) [m]."""
        return float(np.hypot(*(place - self.position))) <= self.reach + margin


@dataclass(slots=True, eq=False)
class _Seen:
    """A place (2,) [m], when a robot showed there last [s], and in how many images in a row."""

    position: FloatArray
    time: float
    images: int = 1


@dataclass(slots=True)
class Tracks:
    """Remembers where robots were seen.

    Parameters
    ----------
    config : VisionConfig
    """

    config: VisionConfig
    _last: dict[NodeId, _Seen] = field(default_factory=dict, init=False)
    _claims: dict[NodeId, _Seen] = field(default_factory=dict, init=False)
    _left: dict[NodeId, _Seen] = field(default_factory=dict, init=False)

    def track(self, robot: NodeId, time: float) -> Track | None:
        """Return where a robot may be at `time` [s]; None if it was never seen."""
        return self._from(self._last.get(robot), time)

    def near(self, robot: NodeId, time: float) -> Track | None:
        """Return where a robot may be that drives only as long as it is seen; None if it never was."""
        seen = self._last.get(robot)
        return None if seen is None else self._from(seen, min(time, seen.time + STOPS_WITHIN_S))

    def left(self, robot: NodeId) -> Track | None:
        """Return where a robot was before somebody carried it, as it seemed; None if nobody did."""
        seen = self._left.get(robot)
        return None if seen is None else self._from(seen, seen.time + STOPS_WITHIN_S)

    def believes(self, robot: NodeId, position: FloatArray, time: float) -> bool:
        """Take a place (2,) [m] at which a robot shows; return whether it is there.

        It is if it can have driven there, or goes on to show there, give or take what it can drive.
        """
        track, left = self.track(robot, time), self.left(robot)
        if track is not None and not track.may_be_at(position):
            claim = self._claims.get(robot)
            goes_on = self._from(claim, time)
            has_leapt = claim is None or goes_on is None or not goes_on.may_be_at(position)
            images = 1 if claim is None or has_leapt else claim.images + 1
            if images < self.config.moved_images:
                self._claims[robot] = _Seen(position, time, images)
                return False
            self._left[robot] = self._last[robot]
        elif left is not None and left.may_be_at(position):
            del self._left[robot]  # it has driven back
        self._last[robot] = _Seen(position, time)
        self._claims.pop(robot, None)
        return True

    def miss(self, robot: NodeId) -> None:
        """Note that an image does not show a robot: what it claims elsewhere begins anew."""
        self._claims.pop(robot, None)

    def forget(self) -> None:
        """Forget all places; what they were measured with has changed."""
        self._last.clear()
        self._claims.clear()
        self._left.clear()

    def _from(self, seen: _Seen | None, time: float) -> Track | None:
        if seen is None or seen.time > time:
            return None
        return Track(seen.position, self.config.reach_m + self.config.reach_mps * (time - seen.time))
