"""Was anything lost? Compares what was recorded with what the nodes have said and heard, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bringup.engine import TickRecord
from recording.taking import Account
from recording.tick_ranges import TickRanges
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.topics import (
    CAMERA_VIEW,
    CLOCK,
    GOALS,
    MARKERS,
    RADIO_RX,
    RADIO_TX,
    ROBOT_ANSWERS,
    ROBOT_MARKERS,
    ROBOT_VIEWS,
    TRUTH,
    Channel,
)
from swarm_msgs_py.types import MISSION, NodeId


@dataclass(frozen=True, slots=True)
class Finding:
    """What an audit has found.

    Attributes
    ----------
    messages : int
        How many were recorded.
    topics : int
        On how many topics.
    expected : int
        How many there must be at least.
    missing : mapping of str to int
        How many are not there, by topic; only of topics that lack some.
    """

    messages: int
    topics: int
    expected: int
    missing: Mapping[str, int]

    def line(self) -> str:
        """Return it for the operator."""
        counted = f"{self.messages} messages on {self.topics} topics"
        if not self.missing:
            return f"recording: {counted}, none lost"
        worst = max(self.missing, key=lambda topic: (self.missing[topic], topic))
        lost = sum(self.missing.values())
        return f"recording: {counted}, {lost} lost, {self.missing[worst]} of them on {worst}; see docs/results.md"


class Audit:
    """Collects which messages each tick must have brought.

    In every tick the world speaks to all that live, and all that answer speak in turn; who answered stands in the
    tick's record. Readings that come now and then are announced by the radio batch of their tick.

    Parameters
    ----------
    shown : tuple of Channel, optional
        What each robot shows to viewers.
    """

    def __init__(self, shown: tuple[Channel, ...] = ROBOT_VIEWS) -> None:
        self._shown = shown
        self._due: dict[str, TickRanges] = {}
        self._course = Course()

    def expect(self, record: TickRecord[Any, Any]) -> None:
        """Take note of one tick."""
        tick = record.tick
        for channel in (CLOCK, TRUTH, ROBOT_MARKERS):
            self._add(channel, tick)
        if record.camera is not None:
            self._add(CAMERA_VIEW, tick)
        for robot in record.reports:
            for channel in (RADIO_RX, *ROBOT_ANSWERS, *self._shown):
                self._add(channel, tick, robot)
        if record.mission is not None:
            self._add(RADIO_RX, tick, MISSION)
            self._add(RADIO_TX, tick, MISSION)
        if record.plan is not None:
            self._course.put(tick, record.plan)
        if record.mission is not None and (record.plan is not None or self._course.is_changing(tick)):
            self._add(GOALS, tick)
            self._add(MARKERS, tick)

    def compare(self, account: Account) -> Finding:
        """Return what is missing in a recording of the ticks so far."""
        nothing = TickRanges()
        last = self._due.get(CLOCK.topic(), nothing).last
        due = dict(self._due)
        for topic, ticks in account.promised.items():
            due[topic] = due.get(topic, nothing).with_all(ticks.up_to(last))
        missing = {topic: ticks.count_without(account.taken.get(topic, nothing)) for topic, ticks in due.items()}
        return Finding(
            messages=account.messages,
            topics=sum(1 for ticks in account.taken.values() if len(ticks)),
            expected=sum(map(len, due.values())),
            missing={topic: count for topic, count in sorted(missing.items()) if count},
        )

    def _add(self, channel: Channel, tick: int, node: NodeId | None = None) -> None:
        self._due.setdefault(channel.topic(node), TickRanges()).add(tick)
