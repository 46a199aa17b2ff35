"""Puts together the records of ticks from what the processes of a run report, in whatever order it comes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from bringup.engine import TickRecord
from bringup.labels import node_list
from bringup.telemetry import AgentReports, MissionTick, WorldTick
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.types import MISSION, NodeId


class TickAssembly:
    """Holds ticks back until the report of everybody who answered in time has come, then hands them out in order."""

    def __init__(self) -> None:
        self._next = 0
        self._worlds: dict[int, WorldTick] = {}
        self._reports: dict[int, dict[NodeId, Any]] = {}
        self._missions: dict[int, MissionTick] = {}
        self._dead: set[NodeId] = set()
        self._alerts: list[str] = []
        self._late_plan: Plan | None = None
        self._forgiven: tuple[int, frozenset[NodeId]] = (-1, frozenset())

    def put_world(self, tick: WorldTick) -> None:
        """Take the world's account of a tick."""
        self._worlds[tick.truth.tick] = tick

    def put_agents(self, reports: AgentReports) -> None:
        """Take the reports of some agents; those that come too late are dropped."""
        if reports.tick >= self._next:
            self._reports.setdefault(reports.tick, {}).update(reports.reports)

    def put_mission(self, tick: MissionTick) -> None:
        """Take the mission computer's report; of one that comes too late the plan and the notice still count."""
        if tick.tick >= self._next:
            self._missions[tick.tick] = tick
        else:
            self._take_late(tick)

    def give_up(self) -> None:
        """Wait no more for the reports of the next tick, if the world has run it; an alert says whose are missing.

        Who reports comes after who answers, so a process that stalls in between owes reports that may never come.
        """
        missing = self.owing
        if missing:
            self._forgiven = (self._next, missing)
            self.alert(f"{node_list(sorted(missing))} answered tick {self._next} but did not report; recorded without")

    def bury(self, nodes: Iterable[NodeId]) -> None:
        """Wait no more for reports of nodes whose process has died."""
        self._dead |= set(nodes)

    def alert(self, line: str) -> None:
        """Put a line into the next record."""
        self._alerts.append(line)

    @property
    def owing(self) -> frozenset[NodeId]:
        """Who answered the next tick, which the world has run, and has not reported it yet."""
        world = self._worlds.get(self._next)
        return self._missing(world) if world is not None else frozenset()

    def take_ready(self) -> Iterator[TickRecord[Any, Any]]:
        """Yield the records that are complete."""
        while self._is_ready():
            yield self._take()

    def _is_ready(self) -> bool:
        world = self._worlds.get(self._next)
        return world is not None and not self._missing(world)

    def _missing(self, world: WorldTick) -> frozenset[NodeId]:
        """Return who has answered the next tick and still owes the report of it."""
        tick, forgiven = self._forgiven
        there: set[NodeId] = {*self._reports.get(self._next, ()), *self._dead}
        if self._next in self._missions:
            there.add(MISSION)
        return world.answered - there - (forgiven if tick == self._next else frozenset())

    def _take(self) -> TickRecord[Any, Any]:
        tick = self._next
        self._next += 1
        world, mission = self._worlds.pop(tick), self._missions.pop(tick, None)
        reports = self._reports.pop(tick, {})
        if MISSION not in world.answered and mission is not None:
            self._take_late(mission)
            mission = None
        late_plan, self._late_plan = self._late_plan, None
        plan = mission.plan if mission is not None and mission.plan is not None else late_plan
        notice = (mission.report.notice,) if mission is not None and mission.report.notice else ()
        alerts, self._alerts = (*self._alerts, *world.alerts, *notice), []
        return TickRecord(
            tick=tick,
            truth=world.truth,
            reports={robot: reports[robot] for robot in sorted(reports.keys() & world.answered)},
            mission=mission.report if mission is not None else None,
            plan=plan,
            alerts=alerts,
            lost=world.lost,
        )

    def _take_late(self, tick: MissionTick) -> None:
        """Keep, for the next record, what must not get lost with a report that came too late."""
        if tick.plan is not None:
            self._late_plan = tick.plan
        if tick.report.notice:
            self.alert(tick.report.notice)
