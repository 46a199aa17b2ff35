"""Which shape when: a schedule of stages that the mission computer works through by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from swarm_msgs_py.types import FloatArray


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
        When it is ordered, if the stages before it are by then [s]; None: as soon as the shape before it stands.
    hold_s : float
        Where there is no time: for how long all robots must have been at rest in the shape before it [s].
    """

    contour: FloatArray
    over_s: float = 0.0
    rotation_rad: float = 0.0
    at_s: float | None = None
    hold_s: float = 0.0

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

    def next_due(self, time: float, rested: float) -> Stage | None:
        """Return the stage to order now, if one is.

        Parameters
        ----------
        time : float
            [s].
        rested : float
            For how long all robots have been at rest in the shape in force, below 0 if they are not [s].
        """
        if self.is_broken_off or not self.left:
            return None
        stage = self._stages[self.done]
        return stage if stage.is_due(time, rested) else None

    def finish(self) -> None:
        """Note that the stage that was due is in force."""
        self.done += 1

    def break_off(self) -> None:
        """Note that the stage that was due cannot be had."""
        self.is_broken_off = True

    def cancel(self) -> None:
        """Forget what is left: the operator has other wishes."""
        self._stages = self._stages[: self.done]
