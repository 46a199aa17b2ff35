"""A goal as a place to drive to: where it is, and how it moves."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import goals_at, is_moving
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """One goal of the plans that follow each other.

    Attributes
    ----------
    course : Course
        Those plans.
    goal : int
        Its id in all of them.
    """

    course: Course
    goal: int

    def at(self, tick: int, period_s: float) -> tuple[FloatArray, FloatArray | None]:
        """Return where the goal is at a tick, (2,) [m], and its mean velocity until the next one, (2,) [m/s].

        The velocity is None if it is at rest for the whole tick.
        """
        plan = self.course.at(tick)
        place: FloatArray = goals_at(plan, tick)[self.goal]
        if not is_moving(plan, tick):
            return place, None
        drift: FloatArray = (goals_at(plan, tick + 1)[self.goal] - place) / period_s
        return place, drift if drift.any() else None
