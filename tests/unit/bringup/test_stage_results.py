"""The numbers of several shapes, from records that are known to the last sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tick_builders import PERIOD, SAMPLES, make_plan, make_tick

from bringup.scenario import SuccessSpec
from bringup.stage_results import motion_results, stage_results
from swarm_msgs_py.messages.bodies import Motion, Plan
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.trace import Trace, TraceRecorder

ROBOTS = (NodeId(0), NodeId(1))
STARTS = np.array([[-2.0, 0.0], [2.0, 0.0]])
FIRST = make_plan(STARTS.tolist())
SHIFT = np.array([12.0, 0.0])
BEGINS, TICKS = 40, 40
LIVE = np.ones(2, dtype=bool)
SUCCESS = SuccessSpec(hold_s=2.0)


def moving(begins: int = BEGINS, ticks: int = TICKS, epoch: int = 2) -> Plan:
    track = np.linspace(FIRST.goals, FIRST.goals + SHIFT, 5)
    motion = Motion(begins, ticks, FIRST.contour, 0.0, track, len(track))
    moved = replace(FIRST, epoch=epoch, contour=FIRST.contour + SHIFT, goals=track[-1])
    return replace(moved, motion=motion, follows=1)


def course_of(*plans: tuple[int, Plan]) -> Course:
    course = Course()
    for tick, plan in plans:
        course.put(tick, plan)
    return course


def recorded(shares: list[float]) -> Trace:
    """Return a record in which the robots are so far on their way in each tick, and at rest where it rests."""
    recorder, before = TraceRecorder(ROBOTS, PERIOD), 0.0
    for tick, share in enumerate(shares):
        record = make_tick(tick, (STARTS + share * SHIFT).tolist(), speed=0.0 if share == before else 0.3)
        recorder.record(record.truth, record.reports)
        before = share
    return recorder.trace()


def smooth(ticks: float) -> float:
    share = min(max(ticks / TICKS, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def following(delay_ticks: int, until: int = 160) -> Trace:
    return recorded([smooth(tick - BEGINS - delay_ticks) for tick in range(until)])


def test_robots_that_follow_late_lag_by_so_much() -> None:
    course = course_of((0, FIRST), (BEGINS - 12, moving()))

    on_time, late = (motion_results(following(delay), course, PERIOD, LIVE) for delay in (0, 10))

    assert on_time is not None
    assert late is not None
    assert on_time.latency_s is not None
    assert late.latency_s is not None
    assert late.latency_s - on_time.latency_s == pytest.approx(5.0, abs=0.5)
    assert (on_time.outside, on_time.recovery_s) == (0.0, 0.0)
    assert late.recovery_s is not None
    assert 0.0 < late.recovery_s <= 5.0


def timed(trace: Trace, period_s: float) -> Trace:
    """Return the record as it is with ticks of another duration, each time a product as engines make them."""
    ticks = len(trace.tick_times)
    tick_times = np.arange(ticks) * period_s
    starts = np.repeat(tick_times, SAMPLES)
    steps = np.tile(period_s * np.arange(1, SAMPLES + 1) / SAMPLES, ticks)
    return replace(trace, tick_times=tick_times, sample_times=np.concatenate([tick_times[:1], starts + steps]))


@pytest.mark.parametrize("begins", [9, 33])
@pytest.mark.parametrize("period_s", [0.05, 0.1, 0.3, 0.7])
def test_motions_are_evaluated_at_any_control_period_also_one_right_after_the_other(
    period_s: float, begins: int
) -> None:
    back = replace(moving(begins + TICKS, epoch=3), contour=FIRST.contour, goals=FIRST.goals)
    assert back.motion is not None
    back = replace(back, motion=replace(back.motion, start=FIRST.contour + SHIFT, track=back.motion.track[::-1]))
    course = course_of((0, FIRST), (0, moving(begins)), (begins, back))
    there = [smooth(tick - begins) for tick in range(begins + TICKS + 1)]
    rest_late = [smooth(TICKS - tick) for tick in range(TICKS // 2)]  # and then they stop half way
    shares = there + rest_late + [rest_late[-1]] * 40
    trace = timed(recorded(shares), period_s)

    first = motion_results(trace, course_of((0, FIRST), (0, moving(begins))), period_s, LIVE)
    both = motion_results(trace, course, period_s, LIVE)

    assert first is not None
    assert both is not None
    assert both.recovery_s is None  # of the second one
    assert both.outside_max == 0.5 > first.outside_max


def test_a_motion_that_is_cut_short_counts_up_to_there_but_has_no_recovery() -> None:
    stay = replace(FIRST, epoch=3, contour=FIRST.contour + SHIFT)
    cut_short = course_of((0, FIRST), (BEGINS, moving()), (BEGINS + 30, stay))
    ends_too_soon = following(0, until=BEGINS + 30)

    for results in (
        motion_results(recorded([0.0] * 160), cut_short, PERIOD, LIVE),
        motion_results(ends_too_soon, course_of((0, FIRST), (20, moving())), PERIOD, LIVE),
    ):
        assert results is not None
        assert results.latency_s is not None
        assert results.recovery_s is None
    behind = motion_results(recorded([0.0] * 160), cut_short, PERIOD, LIVE)
    assert behind is not None
    assert 0.0 < behind.outside < behind.outside_max == 1.0
    assert 0.0 < behind.uncovered < 1.0


def test_a_motion_that_has_hardly_begun_says_nothing_of_a_lag() -> None:
    results = motion_results(following(0, until=BEGINS + 5), course_of((0, FIRST), (20, moving())), PERIOD, LIVE)

    assert results is not None
    assert (results.latency_s, results.outside_max) == (None, 0.0)


def test_without_a_motion_in_the_record_there_are_no_such_numbers() -> None:
    assert motion_results(following(0), course_of((0, FIRST)), PERIOD, LIVE) is None
    assert motion_results(following(0, until=BEGINS), course_of((0, FIRST), (20, moving())), PERIOD, LIVE) is None
    assert motion_results(following(0), course_of((0, FIRST), (20, moving())), PERIOD, ~LIVE) is None


def test_robots_that_stay_behind_for_good_never_recover() -> None:
    results = motion_results(recorded([0.0] * 160), course_of((0, FIRST), (20, moving())), PERIOD, LIVE)

    assert results is not None
    assert results.recovery_s is None
    assert 0.3 < results.outside < 0.8


def test_each_stage_counts_from_its_order_to_rest_in_its_own_shape() -> None:
    away = replace(FIRST, epoch=2, contour=FIRST.contour + SHIFT, goals=FIRST.goals + SHIFT)
    shares = [0.0] * 30 + [min(0.05 * tick, 1.0) for tick in range(1, 41)]

    stages = stage_results(recorded(shares), course_of((0, FIRST), (30, away)), [0, 30], PERIOD, SUCCESS)

    assert [stage.settling_s for stage in stages] == [pytest.approx(0.0), pytest.approx(10.0, abs=PERIOD)]
    assert stages[0].displacement_m == pytest.approx(0.0, abs=0.2)
    assert stages[1].displacement_m == pytest.approx(2 * 12.0, rel=0.05)


def test_a_stage_that_was_never_formed_has_no_settling_time() -> None:
    away = replace(FIRST, epoch=2, contour=FIRST.contour + SHIFT, goals=FIRST.goals + SHIFT)

    (first, second) = stage_results(recorded([0.0] * 60), course_of((0, FIRST), (30, away)), [0, 30], PERIOD, SUCCESS)

    assert first.settling_s is not None
    assert second.settling_s is None


def test_a_stage_that_was_passed_over_keeps_its_place_among_the_others() -> None:
    stages = stage_results(recorded([0.0] * 60), course_of((0, FIRST)), [0, 30, 30], PERIOD, SUCCESS)

    assert [stage.settling_s is None for stage in stages] == [False, True, False]
    assert stages[1].displacement_m == 0.0


def test_before_the_first_order_there_are_no_stages() -> None:
    assert stage_results(recorded([0.0] * 3), Course(), [], PERIOD, SUCCESS) == ()
