"""Whether robots that find their goals by themselves found those of the mission computer."""

from __future__ import annotations

from bringup.engine import FormationRecord
from bringup.labels import node_list
from swarm_msgs_py.types import NodeId


class GoalAgreement:
    """Compares the checksums of goals in the reports with those in the plans (`swarm_msgs_py.plan_goals.goals_crc`).

    Robots with other settings or software drive to places that nobody else knows, and may still all arrive.

    Attributes
    ----------
    alerts : tuple of str
        Of the last tick: one line if robots differ that did not before.
    """

    def __init__(self) -> None:
        self._wanted: dict[int, int] = {}  # checksum by epoch, of plans that have one
        self._seen: set[tuple[int, NodeId]] = set()
        self._differing: set[tuple[int, NodeId]] = set()
        self.alerts: tuple[str, ...] = ()

    @property
    def agreed(self) -> bool | None:
        """Whether no robot ever had other goals than its plan; None if no robot had to find them."""
        return not self._differing if self._seen else None

    def take(self, record: FormationRecord) -> None:
        """Take in one tick."""
        if record.plan is not None and record.plan.goals_crc:
            self._wanted[record.plan.epoch] = record.plan.goals_crc
        different: dict[int, list[NodeId]] = {}
        for robot, report in sorted(record.reports.items()):
            wanted, entry = self._wanted.get(report.epoch), (report.epoch, robot)
            if wanted is None:
                continue
            self._seen.add(entry)
            if report.goals_crc != wanted and entry not in self._differing:
                self._differing.add(entry)
                different.setdefault(report.epoch, []).append(robot)
        self.alerts = tuple(
            f"{node_list(robots)} found other goals for plan {epoch} than the mission computer; give all the same "
            "settings and software"
            for epoch, robots in sorted(different.items())
        )
