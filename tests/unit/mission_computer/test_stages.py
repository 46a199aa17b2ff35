"""Which stage is due when, and when a mission computer may believe that everybody is at rest."""

from __future__ import annotations

import numpy as np
import pytest

from mission_computer.parking import NOT_AT_REST, ParkingWatch
from mission_computer.stages import Stage, StageSchedule
from swarm_msgs_py.messages.bodies import Report
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import NodeId

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
ONE, TWO = NodeId(1), NodeId(2)


def report(robot: NodeId, mode: Mode = Mode.PARKED, epoch: int = 3) -> Report:
    return Report(robot, 1, epoch, 0, (0.0, 0.0), int(mode), 0.1)


def test_a_stage_with_a_time_is_due_from_then_on_whatever_the_robots_do() -> None:
    schedule = StageSchedule([Stage(SQUARE, at_s=20.0)])

    assert schedule.next_due(19.5, rested=100.0) is None
    assert schedule.next_due(20.0, rested=NOT_AT_REST) is not None


def test_a_stage_without_a_time_is_due_when_all_have_been_at_rest_long_enough() -> None:
    schedule = StageSchedule([Stage(SQUARE, hold_s=3.0)])

    assert [schedule.next_due(50.0, rested) is not None for rested in (NOT_AT_REST, 2.5, 3.0)] == [False, False, True]
    at_once = StageSchedule([Stage(SQUARE)])
    assert at_once.next_due(50.0, NOT_AT_REST) is None
    assert at_once.next_due(50.0, 0.0) is not None


def test_stages_come_one_after_the_other() -> None:
    stages = [Stage(SQUARE, over_s=5.0, at_s=1.0), Stage(SQUARE, over_s=5.0, at_s=1.0)]
    schedule = StageSchedule(stages)
    due = []
    while schedule.left:
        due.append(schedule.next_due(5.0, NOT_AT_REST))
        schedule.finish()

    assert due == stages
    assert (schedule.done, schedule.next_due(5.0, 5.0)) == (2, None)


def test_no_stage_is_due_before_the_motion_before_it_is_over() -> None:
    schedule = StageSchedule([Stage(SQUARE, at_s=20.0)])

    due = [schedule.next_due(time, NOT_AT_REST, free_at=50.0) is not None for time in (20.0, 49.5, 50.0)]

    assert due == [False, False, True]


def test_late_stages_that_a_new_shape_would_replace_at_once_are_passed_over() -> None:
    new_shapes = [Stage(SQUARE + shift, at_s=10.0 * shift) for shift in range(1, 4)]
    stages = [Stage(SQUARE, over_s=5.0, at_s=5.0), *new_shapes, Stage(SQUARE, over_s=5.0, at_s=31.0), Stage(SQUARE)]
    schedule = StageSchedule(stages)

    assert schedule.next_due(35.0, NOT_AT_REST) is stages[3]
    schedule.finish()
    assert (schedule.done, schedule.left) == (4, 2)
    assert schedule.next_due(35.5, NOT_AT_REST) is stages[4]


@pytest.mark.parametrize("is_cancelled", [True, False])
def test_what_is_left_never_comes_after_a_break_or_another_wish(is_cancelled: bool) -> None:
    schedule = StageSchedule([Stage(SQUARE), Stage(SQUARE)])
    schedule.finish()

    if is_cancelled:
        schedule.cancel()
    else:
        schedule.break_off()

    assert schedule.next_due(5.0, 5.0) is None
    assert (schedule.left, schedule.is_broken_off) == ((0, False) if is_cancelled else (1, True))


def rested(watch: ParkingWatch, time: float, formed_at: float = 0.0, expected: int = 2) -> float:
    return watch.rested(time, 3, formed_at, (ONE, TWO), expected)


def test_rest_counts_from_the_last_report_of_it() -> None:
    watch = ParkingWatch()
    watch.take(report(ONE), 1.0)

    assert rested(watch, 1.0) == NOT_AT_REST
    watch.take(report(TWO), 2.0)
    assert [rested(watch, time) for time in (2.0, 2.5, 4.0)] == [0.0, 0.5, 2.0]
    assert watch.parked(3) == (ONE, TWO)


@pytest.mark.parametrize("later", [report(TWO, Mode.TRAVELING), report(TWO, epoch=2)])
def test_who_moves_or_knows_another_plan_ends_the_rest(later: Report) -> None:
    watch = ParkingWatch()
    watch.take(report(ONE), 1.0)
    watch.take(report(TWO), 1.0)
    assert rested(watch, 1.0) == 0.0

    watch.take(later, 4.0)
    assert rested(watch, 4.0) == NOT_AT_REST
    watch.take(report(TWO), 6.0)
    assert [rested(watch, 6.0), rested(watch, 8.0)] == [0.0, 2.0]


def test_what_was_reported_while_the_shape_moved_says_nothing() -> None:
    watch = ParkingWatch()
    watch.take(report(ONE), 9.0)
    watch.take(report(TWO), 10.5)

    assert rested(watch, 11.0, formed_at=10.0) == NOT_AT_REST
    watch.take(report(ONE), 11.5)
    assert rested(watch, 11.5, formed_at=10.0) == 0.0


def test_two_of_three_are_not_all() -> None:
    watch = ParkingWatch()
    watch.take(report(ONE), 1.0)
    watch.take(report(TWO), 1.0)

    assert rested(watch, 1.0, expected=3) == NOT_AT_REST
    assert ParkingWatch().rested(1.0, 3, 0.0, (), 0) == NOT_AT_REST
