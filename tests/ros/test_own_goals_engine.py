"""Processes find the goals of a partition themselves, although they are forks of one that may know them."""

from __future__ import annotations

from itertools import islice

import pytest
from swarms import SMALL, SQUARE, SmallSwarm

from bringup.engine import Engine
from bringup.inprocess import InProcessEngine
from bringup.ros_engine import RosEngine
from swarm_msgs_py import partition
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.config import Method, PartitionConfig
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.method import METHODS
from swarm_msgs_py.plan_goals import goals_crc
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray

pytestmark = pytest.mark.usefixtures("domain_id")

SWARM = SmallSwarm(4, task=Task.PARTITION)


class Shifted(BubblePacking):
    """Another method, that is taken for the one of the plan."""

    def __init__(self, config: PartitionConfig) -> None:
        super().__init__(config.bubbles)

    def place(self, domain: Domain) -> FloatArray | None:
        centers = super().place(domain)
        return None if centers is None else centers + 0.1


def checksums(engine: Engine) -> set[int]:
    """Return the checksums of the goals that the robots hold after some ticks."""
    with engine:
        *_, last = islice(engine.ticks(), 4)
        return {report.goals_crc for report in last.reports.values()}


@pytest.mark.usefixtures("nothing_left")
def test_goals_that_the_starting_process_has_kept_are_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    partition.forget()
    with monkeypatch.context() as patch:
        patch.setitem(METHODS, Method.BUBBLE_PACKING, Shifted)
        kept = partition.partition(SQUARE, Roster.of([SMALL] * 4))

    found = checksums(RosEngine(SWARM, agents_per_process=2, deadline_s=5.0))

    partition.forget()
    assert found == checksums(InProcessEngine(SWARM))
    assert len(found) == 1
    assert found != {goals_crc(kept.positions, kept.types)}
