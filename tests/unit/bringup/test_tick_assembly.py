"""Records of ticks are put together from reports in any order, and wait for nobody who is dead or was late."""

from __future__ import annotations

from dataclasses import replace

from tick_builders import make_plan, make_tick

from bringup.telemetry import AgentReports, MissionTick, WorldTick
from bringup.tick_assembly import TickAssembly
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.types import MISSION, NodeId

FIRST, SECOND = NodeId(0), NodeId(1)
PLACES = [[0.0, 0.0], [3.0, 0.0]]
ALL = frozenset({FIRST, SECOND, MISSION})
REPORT = MissionReport(1, (), (), (), "", RadioCounters())
PLAN = make_plan(PLACES)


def world(tick: int, answered: frozenset[NodeId] = ALL, alerts: tuple[str, ...] = ()) -> WorldTick:
    return WorldTick(make_tick(tick, PLACES).truth, answered, alerts, frozenset())


def reports(tick: int, *robots: NodeId) -> AgentReports:
    made = make_tick(tick, PLACES).reports
    return AgentReports(tick, {robot: made[robot] for robot in robots})


def test_a_record_is_ready_when_everybody_who_answered_has_reported() -> None:
    assembly = TickAssembly()
    assembly.put_agents(reports(0, SECOND))
    assembly.put_mission(MissionTick(0, REPORT, PLAN))
    assembly.put_world(world(0))
    assert list(assembly.take_ready()) == []

    assembly.put_agents(reports(0, FIRST))

    (record,) = assembly.take_ready()
    assert list(record.reports) == [FIRST, SECOND]
    assert (record.mission, record.plan) == (REPORT, PLAN)


def test_records_come_in_order_of_ticks() -> None:
    assembly = TickAssembly()
    for tick in (1, 0):
        assembly.put_world(world(tick))
        assembly.put_mission(MissionTick(tick, REPORT, None))
        assembly.put_agents(reports(tick, FIRST, SECOND))

    assert [record.tick for record in assembly.take_ready()] == [0, 1]


def test_who_did_not_answer_in_time_is_neither_waited_for_nor_counted() -> None:
    assembly = TickAssembly()
    assembly.put_world(world(0, answered=frozenset({FIRST}), alerts=("r01 is silent",)))
    assembly.put_agents(reports(0, FIRST, SECOND))

    (record,) = assembly.take_ready()

    assert list(record.reports) == [FIRST]
    assert record.mission is None
    assert record.alerts == ("r01 is silent",)


def test_who_died_after_answering_is_not_waited_for() -> None:
    assembly = TickAssembly()
    assembly.put_world(world(0))
    assembly.put_mission(MissionTick(0, REPORT, None))
    assembly.put_agents(reports(0, FIRST))

    assembly.bury((SECOND,))
    assembly.alert("r01 died")

    (record,) = assembly.take_ready()
    assert list(record.reports) == [FIRST]
    assert record.alerts == ("r01 died",)


def test_a_plan_that_comes_too_late_for_its_tick_is_in_the_next_record() -> None:
    assembly = TickAssembly()
    robots = frozenset({FIRST, SECOND})
    for tick in range(3):
        assembly.put_world(world(tick, answered=robots))
        assembly.put_agents(reports(tick, FIRST, SECOND))
        if tick == 1:
            assembly.put_mission(MissionTick(0, REPORT, PLAN))
        (record,) = assembly.take_ready()

        assert (record.plan is PLAN) == (tick == 1)


def test_the_operators_line_of_the_mission_computer_is_an_alert() -> None:
    assembly = TickAssembly()
    assembly.put_world(world(0))
    assembly.put_agents(reports(0, FIRST, SECOND))
    assembly.put_mission(MissionTick(0, replace(REPORT, notice="shape refused"), None))

    (record,) = assembly.take_ready()

    assert record.alerts == ("shape refused",)


def test_a_report_that_is_given_up_holds_up_its_tick_no_longer_and_is_told_of() -> None:
    assembly = TickAssembly()
    assembly.put_world(world(0))
    assembly.put_agents(reports(0, FIRST))
    assembly.put_mission(MissionTick(0, REPORT, None))
    assert list(assembly.take_ready()) == []

    assembly.give_up()

    (record,) = assembly.take_ready()
    assert list(record.reports) == [FIRST]
    assert record.alerts == ("r01 answered tick 0 but did not report; recorded without",)


def test_reports_are_owed_from_when_the_world_has_run_the_tick_until_they_come() -> None:
    assembly = TickAssembly()
    assembly.put_agents(reports(0, FIRST))
    before = assembly.owing
    assembly.put_world(world(0, answered=frozenset({FIRST, SECOND})))
    after = assembly.owing
    assembly.put_agents(reports(0, SECOND))

    assert (before, after, assembly.owing) == (frozenset(), {SECOND}, frozenset())


def test_giving_up_one_tick_gives_up_no_other() -> None:
    assembly = TickAssembly()
    for tick in (0, 1):
        assembly.put_world(world(tick, answered=frozenset({FIRST})))
    assembly.give_up()

    assert [record.tick for record in assembly.take_ready()] == [0]

    assembly.put_agents(reports(1, FIRST))
    (record,) = assembly.take_ready()
    assert (list(record.reports), record.alerts) == ([FIRST], ())


def test_a_given_up_mission_computer_has_its_plan_counted_when_it_comes() -> None:
    assembly = TickAssembly()
    for tick in (0, 1):
        assembly.put_world(world(tick, answered=frozenset({MISSION})))
    assembly.give_up()
    (first,) = assembly.take_ready()
    for tick in (0, 1):
        assembly.put_mission(MissionTick(tick, REPORT, PLAN if tick == 0 else None))

    (second,) = assembly.take_ready()

    assert first.alerts == ("mission computer answered tick 0 but did not report; recorded without",)
    assert (first.mission, first.plan) == (None, None)
    assert (second.mission, second.plan) == (REPORT, PLAN)


def test_nothing_is_given_up_of_a_tick_that_the_world_has_not_run() -> None:
    assembly = TickAssembly()
    assembly.give_up()
    assembly.put_world(world(0, answered=frozenset({FIRST})))

    assert list(assembly.take_ready()) == []


def test_a_late_plan_never_comes_after_a_newer_one() -> None:
    assembly = TickAssembly()
    robots = frozenset({FIRST, SECOND})
    newer = replace(PLAN, epoch=2)
    assembly.put_world(world(0, answered=robots))
    assembly.put_agents(reports(0, FIRST, SECOND))
    records = list(assembly.take_ready())
    assembly.put_mission(MissionTick(0, REPORT, PLAN))  # too late for tick 0
    for tick, plan in ((1, newer), (2, None)):
        assembly.put_world(world(tick))
        assembly.put_agents(reports(tick, FIRST, SECOND))
        assembly.put_mission(MissionTick(tick, REPORT, plan))

    records += assembly.take_ready()

    assert [record.plan for record in records] == [None, newer, None]


def test_the_notice_of_a_late_mission_computer_is_not_lost() -> None:
    assembly = TickAssembly()
    robots = frozenset({FIRST, SECOND})
    for tick in (0, 1):
        assembly.put_world(world(tick, answered=robots))
        assembly.put_agents(reports(tick, FIRST, SECOND))
    assembly.put_mission(MissionTick(0, replace(REPORT, notice="shape refused"), None))  # unanswered, yet in time
    records = list(assembly.take_ready())
    assembly.put_mission(MissionTick(1, replace(REPORT, notice="r03 is lost"), None))  # after the record was made
    assembly.put_world(world(2, answered=robots))
    assembly.put_agents(reports(2, FIRST, SECOND))

    records += assembly.take_ready()

    assert [line for record in records for line in record.alerts] == ["shape refused", "r03 is lost"]
