"""Which plan says where things are, while another one is about to begin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import make_plan

from swarm_msgs_py.messages.bodies import Motion, Plan
from swarm_msgs_py.plan_course import Course, lineage


def plan(epoch: int, begins: int | None = None, follows: int = 0) -> Plan:
    still = make_plan(np.zeros((1, 2)), epoch=epoch)
    if begins is None:
        return still
    motion = Motion(begins, 10, still.contour, 0.0, np.zeros((2, 1, 2)), 2)
    return replace(still, motion=motion, follows=follows)


def epochs(course: Course, *ticks: float) -> list[int]:
    return [course.at(tick).epoch for tick in ticks]


def course_of(*heard: tuple[int, Plan]) -> Course:
    course = Course()
    for tick, each in heard:
        course.put(tick, each)
    return course


def test_a_motion_applies_from_its_beginning_and_any_other_plan_at_once() -> None:
    course = course_of((3, plan(1)), (8, plan(2, begins=20)), (40, plan(3)))

    assert epochs(course, 0, 3, 19, 19.5, 20, 39, 40, 99) == [1, 1, 1, 1, 2, 2, 3, 3]
    assert [(since, each.epoch) for since, each in course.plans] == [(3, 1), (20, 2), (40, 3)]


def test_a_motion_that_is_heard_late_applies_at_once() -> None:
    assert epochs(course_of((3, plan(1)), (25, plan(2, begins=20))), 24, 25) == [1, 2]


def test_the_first_plan_heard_applies_even_before_its_motion_begins() -> None:
    assert epochs(course_of((5, plan(2, begins=20))), 5, 20) == [2, 2]


@pytest.mark.parametrize(("newer", "expected"), [(plan(3), [3, 3, 3]), (plan(3, begins=15), [1, 3, 3])])
def test_a_newer_plan_replaces_those_that_have_not_begun(newer: Plan, expected: list[int]) -> None:
    course = course_of((0, plan(1)), (8, plan(2, begins=20)), (10, newer))

    assert epochs(course, 12, 15, 30) == expected


def test_things_change_from_one_tick_to_the_next_while_a_motion_lasts() -> None:
    course = course_of((3, plan(1)), (8, plan(2, begins=20)))

    assert [course.is_changing(tick) for tick in (8, 19, 20, 21, 30, 31)] == [False, False, False, True, True, False]
    assert not Course().is_changing(5)


def test_without_any_plan_there_is_no_answer() -> None:
    with pytest.raises(LookupError):
        Course().at(0)


def test_goals_have_the_ids_of_the_plan_that_they_come_from() -> None:
    assert [lineage(plan(4)), lineage(plan(5, begins=9, follows=4)), lineage(plan(6, begins=9))] == [4, 4, 6]
