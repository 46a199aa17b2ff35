from __future__ import annotations

from dataclasses import replace

from tick_builders import PERIOD, make_plan, make_tick

from bringup.engine import TickRecord
from bringup.goal_agreement import GoalAgreement
from bringup.scenario import SuccessSpec
from bringup.supervisor import Supervisor
from swarm_msgs_py.types import NodeId

POINTS = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]
WANTED, OTHER = 17, 18


def tick(number: int, *crcs: int, wanted: int | None = None) -> TickRecord:
    """Return a tick in which robots report these checksums; with `wanted`, one that brings the plan."""
    plan = None if wanted is None else replace(make_plan(POINTS), goals_crc=wanted)
    record = make_tick(number, POINTS, plan=plan)
    reports = {robot: replace(record.reports[robot], goals_crc=crc) for robot, crc in enumerate_robots(crcs)}
    return replace(record, reports=reports)


def enumerate_robots(crcs: tuple[int, ...]) -> list[tuple[NodeId, int]]:
    return [(NodeId(robot), crc) for robot, crc in enumerate(crcs)]


def test_equal_goals_agree() -> None:
    agreement = GoalAgreement()
    agreement.take(tick(0, WANTED, WANTED, WANTED, wanted=WANTED))

    assert agreement.agreed is True
    assert agreement.alerts == ()


def test_other_goals_are_told_once_and_remembered() -> None:
    agreement = GoalAgreement()
    agreement.take(tick(0, WANTED, OTHER, WANTED, wanted=WANTED))
    first = agreement.alerts
    agreement.take(tick(1, WANTED, OTHER, WANTED))

    assert len(first) == 1
    assert first[0].startswith("r01 found other goals for plan 1 than the mission computer")
    assert agreement.alerts == ()
    agreement.take(tick(2, WANTED, WANTED, WANTED))
    assert agreement.agreed is False


def test_a_robot_that_finds_no_goals_differs() -> None:
    agreement = GoalAgreement()
    agreement.take(tick(0, WANTED, 0, WANTED, wanted=WANTED))

    assert agreement.agreed is False


def test_without_a_checksum_there_is_nothing_to_agree_on() -> None:
    agreement = GoalAgreement()
    agreement.take(tick(0, 5, 6, 7, wanted=0))

    assert agreement.agreed is None
    assert agreement.alerts == ()


def test_reports_of_an_older_plan_are_held_against_that_plan() -> None:
    agreement = GoalAgreement()
    agreement.take(tick(0, WANTED, WANTED, WANTED, wanted=WANTED))
    agreement.take(replace(tick(1, WANTED, WANTED, WANTED), plan=replace(make_plan(POINTS), epoch=2, goals_crc=OTHER)))

    assert agreement.agreed is True


def test_the_supervisor_watches_it() -> None:
    robots = tuple(NodeId(robot) for robot in range(3))
    supervisor = Supervisor(robots, SuccessSpec(), PERIOD, 60.0)
    supervisor.watch(tick(0, WANTED, OTHER, OTHER, wanted=WANTED))

    assert supervisor.goal_agreement.agreed is False
    assert "r01, r02" in supervisor.goal_agreement.alerts[0]
