"""Plans one after the other: which of them says where the shape and the goals are at a time.

A plan with a motion is heard some seconds before the motion begins, and begins where the plan before it will have led
to by then. So until it begins, the plan before it still says how things move.
"""

from __future__ import annotations

from bisect import bisect_right

from swarm_msgs_py.messages.bodies import Plan


def lineage(plan: Plan) -> int:
    """Return the epoch of the plan that gave the goals of this one their ids: its own, unless it follows another."""
    return plan.follows or plan.epoch


class Course:
    """The plans that somebody has heard, in order of when they apply."""

    def __init__(self) -> None:
        self._since: list[int] = []  # first tick of each plan
        self._plans: list[Plan] = []

    @property
    def plans(self) -> tuple[tuple[int, Plan], ...]:
        """All plans that have applied or will, each with the first tick in which it does."""
        return tuple(zip(self._since, self._plans, strict=True))

    def put(self, tick: int, plan: Plan) -> None:
        """Take a newer plan, heard at a tick; a plan that would have applied later never will."""
        begins = tick if plan.motion is None or not self._plans else max(tick, plan.motion.begins)
        kept = bisect_right(self._since, begins - 1)
        self._since[kept:], self._plans[kept:] = [begins], [plan]

    def is_changing(self, tick: int) -> bool:
        """Return whether a motion has moved shape and goals since the tick before."""
        if not self._plans:
            return False
        motion = self.at(tick).motion
        return motion is not None and motion.begins < tick <= motion.ends

    def at(self, tick: float) -> Plan:
        """Return the plan that applies at a tick; before the first one, that.

        Raises
        ------
        LookupError
            If there is no plan at all.
        """
        return self._plans[max(bisect_right(self._since, tick) - 1, 0)]
