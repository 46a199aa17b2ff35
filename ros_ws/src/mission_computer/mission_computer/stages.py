"""Which shape when: a schedule of stages that the mission computer works through by itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from swarm_msgs_py.types import FloatArray

MOMENT = 1e-9  # [s]; times are products of ticks and their duration


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One shape of a schedule, how it comes about, and when that is ordered.

    Attributes
    ----------
    contour : (k, 2) array
        The shape [m].
    over_s : float
        For how long the shape before it turns into it; 0: it is ordered as a new shape [s].
    rotation_rad : float
        By how much the shape turns on the way, counter-clockwise [rad].
    at_s : float or None
        When it is ordered, if the motion before it is over by then, or else when it is [s]; None: as soon as the shape
        before it stands.
    hold_s : float
        Where there is no time: for how long all robots must have been at rest in the shape before it [s].
    heading : float or None
        Direction that the robots are to face in it [rad]; None: that is left to them.
    """

    contour: FloatArray
    over_s: float = 0.0
    rotation_rad: float = 0.0
    at_s: float | None = None
    hold_s: float = 0.0
    heading: float | None = None

    def is_due(self, time: float, rested: float) -> bool:
        """Return whether it is to be ordered at `time` [s], when all have been at rest for `rested` [s]."""
        return rested >= self.hold_s if self.at_s is None else time >= self.at_s


class StageSchedule:
    """Stages in their order; each is handed out once.

    A schedule that is broken off goes no further: a stage that cannot be had leaves those after it without a beginning.

    Parameters
    ----------
    stages : sequence of Stage

    Attributes
    ----------
    done : int
        Stages handed out.
    is_broken_off : bool
    """

    def __init__(self, stages: Sequence[Stage]) -> None:
        self._stages = tuple(stages)
        self.done = 0
        self.is_broken_off = False

    @property
    def left(self) -> int:
        """Stages that are still to come, or would be."""
        return len(self._stages) - self.done

    def next_due(self, time: float, rested: float, free_at: float = -math.inf) -> Stage | None:
        """Return the stage to order now, if one is.

        Stages that are late, as after a restart of the mission computer, come one after the other as their motions end.
        Those that a new shape would replace at once are passed over; they count as handed out.

        Parameters
        ----------
        time : float
            [s].
        rested : float
            For how long all robots have been at rest in the shape in force, below 0 if they are not [s].
        free_at : float
            When the motion that was ordered last ends [s].
        """
        is_over = self.is_broken_off or not self.left
        if is_over or time < free_at - MOMENT or not self._stages[self.done].is_due(time, rested):
            return None
        for number in range(self.done + 1, len(self._stages)):
            at_s = self._stages[number].at_s
            if at_s is None or time < at_s:
                break
            if self._stages[number].over_s == 0.0:
                self.done = number
        return self._stages[self.done]

    def finish(self) -> None:
        """Note that the stage that was due is in force."""
        self.done += 1

    def break_off(self) -> None:
        """Note that the stage that was due cannot be had."""
        self.is_broken_off = True

    def cancel(self) -> None:
        """Forget what is left: the operator has other wishes."""
        self._stages = self._stages[: self.done]
