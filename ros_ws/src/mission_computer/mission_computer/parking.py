"""Whether the shape stands, as far as a mission computer can tell: from what the robots report."""

from __future__ import annotations

from collections.abc import Collection

from swarm_msgs_py.messages.bodies import Report
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import NodeId

NOT_AT_REST = -1.0
"""Time at rest of a swarm that is not."""


class ParkingWatch:
    """Watches who is at rest under the plan in force, and for how long everybody has been."""

    def __init__(self) -> None:
        self._reports: dict[NodeId, tuple[float, Report]] = {}  # and when they came [s]
        self._since: float | None = None

    def take(self, report: Report, time: float) -> None:
        """Note a report that came at `time` [s]."""
        self._reports[report.robot] = time, report

    def parked(self, epoch: int) -> tuple[NodeId, ...]:
        """Return who last reported to be at rest under a plan, ascending."""
        return tuple(robot for robot in sorted(self._reports) if self._is_parked(robot, epoch))

    def rested(self, time: float, epoch: int, formed_at: float, robots: Collection[NodeId], expected: int) -> float:
        """Return for how long all have been at rest, below 0 if they are not [s]; to be asked every tick.

        Parameters
        ----------
        time : float
            [s].
        epoch : int
            Of the plan in force.
        formed_at : float
            Time from which on its shape does not move any more; what was reported before says nothing [s].
        robots : collection of NodeId
            Who is there.
        expected : int
            How many that ought to be at least.
        """
        is_there = time >= formed_at and len(robots) >= max(expected, 1)
        is_at_rest = is_there and all(
            self._is_parked(robot, epoch) and self._reports[robot][0] >= formed_at for robot in robots
        )
        if not is_at_rest:
            self._since = None
            return NOT_AT_REST
        if self._since is None:
            self._since = time
        return time - self._since

    def _is_parked(self, robot: NodeId, epoch: int) -> bool:
        if robot not in self._reports:
            return False
        _, report = self._reports[robot]
        return report.mode == Mode.PARKED and report.epoch == epoch
