"""When a run of several shapes, or of one that moves, counts as achieved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tick_builders import PERIOD, make_plan, make_tick

from bringup.engine import TickRecord
from bringup.scenario import SuccessSpec
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.messages.bodies import Motion, Plan
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.plan_motion import goals_at
from swarm_msgs_py.types import MISSION, NodeId

ROBOTS = (NodeId(0), NodeId(1))
STARTS = [[0.0, 0.0], [2.0, 0.0]]
FIRST = make_plan(STARTS)
SHIFT = np.array([20.0, 0.0])
BEGINS, TICKS = 10, 40


def moving(follows: int = 1) -> Plan:
    track = np.linspace(FIRST.goals, FIRST.goals + SHIFT, 5)
    motion = Motion(BEGINS, TICKS, FIRST.contour, 0.0, track, len(track))
    moved = replace(FIRST, epoch=2, contour=FIRST.contour + SHIFT, goals=track[-1])
    return replace(moved, motion=motion, follows=follows)


def make_supervisor(duration_s: float = 1000.0) -> Supervisor:
    return Supervisor(ROBOTS, SuccessSpec(goal_tolerance_m=0.25), PERIOD, duration_s)


def with_mission(record: TickRecord, stage: int, left: int, *, is_broken_off: bool = False) -> TickRecord:
    report = MissionReport(1, (), (), (), "", RadioCounters(), stage, left, is_broken_off)
    return replace(record, mission=report)


def at_rest(ticks: int, first: int, stage: int, left: int, **changes: object) -> list[TickRecord]:
    is_broken_off = bool(changes.pop("is_broken_off", False))
    records = [make_tick(tick, STARTS, **changes) for tick in range(first, first + ticks)]  # type: ignore[arg-type]
    return [with_mission(record, stage, left, is_broken_off=is_broken_off) for record in records]


def verdict_of(supervisor: Supervisor, records: list[TickRecord]) -> tuple[int, Verdict] | None:
    for record in records:
        verdict = supervisor.watch(record)
        if verdict is not None:
            return record.tick, verdict
    return None


def first_tick(stages_left: int) -> TickRecord:
    return with_mission(make_tick(0, STARTS, plan=FIRST, speed=0.3), 0, stages_left)


def test_rest_in_a_shape_that_is_not_the_last_one_is_no_end() -> None:
    supervisor = make_supervisor()
    again = with_mission(make_tick(30, STARTS, plan=replace(FIRST, epoch=2)), 1, 0)

    assert verdict_of(supervisor, [first_tick(1), *at_rest(29, 1, 0, 1)]) is None
    found = verdict_of(supervisor, [again, *at_rest(20, 31, 1, 0)])

    assert found is not None
    assert found[1].achieved
    assert found[1].reason.startswith("last of 2 shapes formed: 2 of 2 robots at their goals")
    assert supervisor.stages == [0, 30]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"is_broken_off": True}, "; 2 stages to come, but stage 1 was refused; see the alerts for why"),
        ({"lost": frozenset({MISSION})}, "; 2 stages to come, but the mission computer is off"),
    ],
)
def test_a_schedule_that_ends_early_ends_the_run_at_rest(changes: dict[str, object], reason: str) -> None:
    found = verdict_of(make_supervisor(), [first_tick(2), *at_rest(20, 1, 0, 2, **changes)])

    assert found is not None
    assert found[0] < 12
    assert not found[1].achieved
    assert found[1].reason.endswith(reason)


def test_out_of_time_the_stages_to_come_are_the_reason() -> None:
    found = verdict_of(make_supervisor(duration_s=20.0), [first_tick(1), *at_rest(60, 1, 0, 1)])

    assert found is not None
    assert found[1].reason == "time limit of 20 s: 2 of 2 robots at their goals; 1 stage to come"


def test_out_of_time_in_mid_motion_the_shape_is_said_to_have_been_moving() -> None:
    plan = replace(moving(), epoch=1)
    records = [with_mission(along(tick, plan if tick == 1 else None), 1, 2) for tick in range(1, 30)]

    found = verdict_of(make_supervisor(duration_s=15.0), [first_tick(0), *records])

    assert found is not None
    assert found[1].reason.endswith("; the shape was still moving; 2 stages to come")


def test_a_stage_that_was_passed_over_counts_from_when_the_next_one_was_ordered() -> None:
    supervisor = make_supervisor()
    again = with_mission(make_tick(30, STARTS, plan=replace(FIRST, epoch=2)), 2, 0)

    verdict_of(supervisor, [first_tick(2), *at_rest(29, 1, 0, 2), again])

    assert supervisor.stages == [0, 30, 30]


def along(tick: int, plan: Plan | None = None) -> TickRecord:
    """Return a tick in which both robots are, at its end, exactly where their goals are then."""
    places = goals_at(moving(), tick + 1)
    return with_mission(make_tick(tick, places.tolist(), plan=plan), 1, 0)


def test_robots_are_judged_by_where_shape_and_goals_are_at_the_time() -> None:
    supervisor = make_supervisor()
    supervisor.watch(first_tick(1))
    there, found = [], None
    for tick in range(1, 80):
        found = supervisor.watch(along(tick, moving() if tick == 4 else None))
        there.append(supervisor.at_goal)
        if found is not None:
            break

    assert set(there) == {2}
    assert found is not None
    assert found.achieved
    assert tick == BEGINS + TICKS + 6  # 3 s after the shape came to rest, as after any other
    assert "at rest since 25.0 s" in found.reason or "at rest since 25.1 s" in found.reason


def test_who_stays_behind_a_moving_shape_is_not_at_its_goal() -> None:
    supervisor = make_supervisor()
    supervisor.watch(first_tick(1))
    counts = []
    for tick in range(1, 40):
        supervisor.watch(with_mission(make_tick(tick, STARTS, plan=moving() if tick == 4 else None), 1, 0))
        counts.append(supervisor.at_goal)

    assert counts[: BEGINS - 2] == [2] * (BEGINS - 2)
    assert counts[-1] == 0


def test_goals_that_were_shared_out_anew_count_by_their_own_ids_before_they_move() -> None:
    supervisor = make_supervisor()
    supervisor.watch(first_tick(0))
    swapped = moving(follows=0)
    assert swapped.motion is not None
    swapped = replace(swapped, motion=replace(swapped.motion, track=swapped.motion.track[:, ::-1]))

    supervisor.watch(with_mission(make_tick(4, STARTS, [1, 0], plan=swapped), 0, 0))

    assert supervisor.at_goal == 2
