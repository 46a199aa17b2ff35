from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tick_builders import PERIOD, make_plan, make_tick

from bringup.engine import TickRecord
from bringup.scenario import SuccessSpec
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import MISSION, NodeId

ROBOTS = (NodeId(0), NodeId(1))
PLAN = make_plan([[0.0, 0.0], [2.0, 0.0]])
AT_GOALS = [[0.1, 0.0], [2.0, 0.1]]
HOLD_TICKS = 6  # 3 s at 0.5 s; rest is counted from the first sample on, so one tick more is needed


def make_supervisor(duration_s: float = 1000.0, live_share_min: float = 0.5) -> Supervisor:
    return Supervisor(ROBOTS, SuccessSpec(live_share_min=live_share_min, goal_tolerance_m=0.25), PERIOD, duration_s)


def first_verdict(supervisor: Supervisor, records: list[TickRecord]) -> tuple[int, Verdict] | None:
    for record in records:
        verdict = supervisor.watch(record)
        if verdict is not None:
            return record.tick, verdict
    return None


def resting(ticks: int, points: list[list[float]], start: int = 1, **changes: object) -> list[TickRecord]:
    return [make_tick(tick, points, **changes) for tick in range(start, start + ticks)]


def test_rest_at_the_goals_for_the_hold_time_is_success() -> None:
    supervisor = make_supervisor()
    found = first_verdict(supervisor, [make_tick(0, AT_GOALS, plan=PLAN, speed=0.3), *resting(20, AT_GOALS)])

    assert found is not None
    tick, verdict = found
    assert verdict.achieved
    assert tick == HOLD_TICKS + 1
    assert supervisor.at_goal == 2
    assert "2 of 2 robots" in verdict.reason


def test_moving_robots_have_not_succeeded() -> None:
    records = [make_tick(0, AT_GOALS, plan=PLAN), *resting(30, AT_GOALS, speed=0.011)]

    assert first_verdict(make_supervisor(), records) is None


def test_a_twitch_restarts_the_hold_time() -> None:
    records = [make_tick(0, AT_GOALS, plan=PLAN), *resting(4, AT_GOALS), make_tick(5, AT_GOALS, speed=0.5)]

    found = first_verdict(make_supervisor(), [*records, *resting(20, AT_GOALS, start=6)])

    assert found is not None
    assert found[0] == 5 + HOLD_TICKS + 1


def test_rest_inside_but_off_the_goal_is_no_success() -> None:
    records = [make_tick(0, AT_GOALS, plan=PLAN), *resting(30, [[0.0, 0.3], [2.0, 0.0]])]
    supervisor = make_supervisor()

    assert first_verdict(supervisor, records) is None
    assert supervisor.at_goal == 1


def test_rest_at_a_goal_outside_the_contour_is_no_success() -> None:
    plan = make_plan([[0.0, 0.0], [5.1, 0.0]])

    records = [make_tick(0, AT_GOALS, plan=plan), *resting(30, [[0.0, 0.0], [5.1, 0.0]])]

    assert first_verdict(make_supervisor(), records) is None


def test_nothing_is_achieved_without_a_plan() -> None:
    assert first_verdict(make_supervisor(), resting(30, AT_GOALS)) is None


def test_a_new_plan_must_be_held_anew() -> None:
    swapped = make_plan([[2.0, 0.0], [0.0, 0.0]])
    records = [
        make_tick(0, AT_GOALS, plan=PLAN),
        *resting(4, AT_GOALS),
        make_tick(5, AT_GOALS, plan=swapped),
        *resting(20, AT_GOALS, start=6),
    ]
    supervisor = make_supervisor()

    assert first_verdict(supervisor, records) is None
    assert supervisor.at_goal == 0


def test_the_living_succeed_without_the_dead() -> None:
    dead = frozenset({NodeId(1)})
    records = [make_tick(0, AT_GOALS, plan=PLAN), *resting(20, [[0.0, 0.0], [9.0, 9.0]], lost=dead)]

    found = first_verdict(make_supervisor(), records)

    assert found is not None
    assert found[1].achieved
    assert "1 of 1 robots at their goals, 1 lost" in found[1].reason


def test_a_shape_of_too_few_survivors_is_no_success() -> None:
    dead = frozenset({NodeId(1)})
    records = [make_tick(0, AT_GOALS, plan=PLAN), *resting(20, [[0.0, 0.0], [9.0, 9.0]], lost=dead)]

    found = first_verdict(make_supervisor(live_share_min=0.75), records)

    assert found is not None
    assert not found[1].achieved
    assert found[1].reason.startswith("only 1 of 2 robots live, 2 must (success.live_share_min)")


def test_a_swarm_without_anybody_alive_has_failed() -> None:
    found = first_verdict(make_supervisor(), resting(5, AT_GOALS, lost=frozenset(ROBOTS)))

    assert found is not None
    assert not found[1].achieved
    assert "all 2 robots are lost" in found[1].reason


def test_a_mission_computer_that_dies_before_the_plan_ends_the_run() -> None:
    found = first_verdict(make_supervisor(), resting(5, AT_GOALS, lost=frozenset({MISSION})))

    assert found is not None
    assert found[1].reason.startswith("the mission computer died")


def test_a_mission_computer_that_dies_after_the_plan_does_not_matter() -> None:
    records = [make_tick(0, AT_GOALS, plan=PLAN), *resting(20, AT_GOALS, lost=frozenset({MISSION}))]

    found = first_verdict(make_supervisor(), records)

    assert found is not None
    assert found[1].achieved


def test_the_time_limit_names_who_is_missing() -> None:
    found = first_verdict(make_supervisor(2.0), [make_tick(0, AT_GOALS, plan=PLAN), *resting(30, [[0, 0], [2, 4]])])

    assert found is not None
    tick, verdict = found
    assert (tick + 1) * PERIOD == 2.0
    assert verdict.reason == "time limit of 2 s: 1 of 2 robots at their goals; r01 4.0 m away"


def test_the_time_limit_says_that_there_was_no_plan() -> None:
    found = first_verdict(make_supervisor(2.0), resting(30, AT_GOALS))

    assert found is not None
    assert "no plan was made" in found[1].reason


def test_success_in_the_last_tick_counts() -> None:
    duration = PERIOD * (HOLD_TICKS + 2)
    records = [make_tick(0, AT_GOALS, plan=PLAN, speed=0.3), *resting(30, AT_GOALS)]

    found = first_verdict(make_supervisor(duration), records)

    assert found is not None
    assert found[1].achieved


def test_an_interrupted_run_says_when_and_how_far_it_was() -> None:
    supervisor = make_supervisor()
    supervisor.watch(make_tick(0, AT_GOALS, plan=PLAN))

    assert supervisor.interrupted(0.5) == Verdict(
        False, "interrupted by the operator at 0.5 s: 2 of 2 robots at their goals"
    )


def test_a_robot_that_reports_no_goal_is_not_at_one() -> None:
    supervisor = make_supervisor()
    supervisor.watch(make_tick(0, AT_GOALS, goals=[-1, 1], plan=PLAN))

    assert supervisor.at_goal == 1


def reported(record: TickRecord, **changes: object) -> TickRecord:
    """Return the tick with every report changed."""
    return replace(record, reports={robot: replace(report, **changes) for robot, report in record.reports.items()})


def late_reason(records: list[TickRecord]) -> str:
    found = first_verdict(make_supervisor(2.0), records)
    assert found is not None
    return found[1].reason


def test_the_time_limit_says_who_has_no_position() -> None:
    ticks = [make_tick(0, AT_GOALS, plan=PLAN), *resting(9, [[0, 0], [2, 4]])]

    reason = late_reason([reported(tick, position=np.full(2, np.nan), goal=-1) for tick in ticks])

    assert "2 have no position (robots.position_sensor_share)" in reason


def test_under_a_camera_it_names_the_camera() -> None:
    ticks = [make_tick(0, AT_GOALS, plan=PLAN), *resting(9, [[0, 0], [2, 4]])]
    supervisor = Supervisor(ROBOTS, SuccessSpec(), PERIOD, 2.0, is_under_camera=True)

    found = first_verdict(supervisor, [reported(tick, position=np.full(2, np.nan), goal=-1) for tick in ticks])

    assert found is not None
    assert "2 have no position (the camera gave them no fix" in found[1].reason


@pytest.mark.parametrize(
    ("lost", "why"), [(frozenset(), "out of radio range"), (frozenset({MISSION}), "the mission computer is off")]
)
def test_robots_that_wait_for_the_plan_are_not_called_blind(lost: frozenset[NodeId], why: str) -> None:
    ticks = [make_tick(0, AT_GOALS, plan=PLAN), *resting(9, [[0, 0], [2, 4]], lost=lost)]

    reason = late_reason([reported(tick, epoch=0, goal=-1, mode=Mode.WAITING) for tick in ticks])

    assert f"2 never heard the plan ({why}" in reason
    assert "position" not in reason


def test_the_time_limit_says_who_never_answered() -> None:
    ticks = [make_tick(0, AT_GOALS, plan=PLAN), *resting(9, [[0, 0], [2, 4]])]

    assert "2 never answered" in late_reason([replace(tick, reports={}) for tick in ticks])


def test_only_another_contour_is_a_change_of_shape() -> None:
    supervisor = make_supervisor()
    supervisor.watch(make_tick(0, AT_GOALS, plan=PLAN))
    supervisor.watch(make_tick(1, AT_GOALS, plan=make_plan([[2.0, 0.0]])))
    same_shape = supervisor.has_changed_shape
    supervisor.watch(make_tick(2, AT_GOALS, plan=make_plan([[2.0, 0.0]], contour=((0, 0), (4, 0), (4, 4)))))

    assert (same_shape, supervisor.has_changed_shape) == (False, True)


def in_contour(points: list[list[float]], ticks: int = 30, **changes: object) -> list[TickRecord]:
    """Return ticks of a plan without goals, in which the robots stand at their points."""
    plan = replace(make_plan([]), task=Task.FORCES)
    return [make_tick(0, points, [-1, -1], plan=plan), *resting(ticks, points, goals=[-1, -1], **changes)]


def test_without_goals_rest_inside_the_shape_is_success() -> None:
    supervisor = make_supervisor()
    found = first_verdict(supervisor, in_contour([[4.9, 0.0], [-3.0, 4.0]]))

    assert found is not None
    assert found[0] == HOLD_TICKS
    assert found[1].reason == "shape formed: 2 of 2 robots inside the shape, at rest since 0.1 s"
    assert supervisor.at_goal == 2


def test_without_goals_whoever_moves_or_stands_outside_has_not_succeeded() -> None:
    moving, outside = make_supervisor(2.0), make_supervisor(2.0)

    moved = first_verdict(moving, in_contour([[0.0, 0.0], [1.0, 0.0]], speed=0.02))
    strayed = first_verdict(outside, in_contour([[0.0, 0.0], [6.5, 0.0]]))

    assert moved is not None
    assert moved[1].reason == "time limit of 2 s: 2 of 2 robots inside the shape; not at rest inside the shape"
    assert strayed is not None
    assert strayed[1].reason == "time limit of 2 s: 1 of 2 robots inside the shape; r01 1.5 m away"


def test_a_tolerance_for_goals_is_none_for_the_contour() -> None:
    supervisor = make_supervisor()

    assert first_verdict(supervisor, in_contour([[0.0, 0.0], [5.1, 0.0]])) is None
    assert supervisor.at_goal == 1


def test_without_goals_whoever_has_not_heard_the_plan_is_not_there() -> None:
    supervisor = make_supervisor(10.0)
    second = replace(make_plan([]), task=Task.FORCES, epoch=2)
    records = [
        make_tick(0, AT_GOALS, [-1, -1], plan=second),
        *resting(30, AT_GOALS, goals=[-1, -1]),
    ]  # they hold plan 1

    found = first_verdict(supervisor, records)

    assert found is not None
    assert not found[1].achieved
    assert "0 of 2 robots inside the shape; 2 never heard the plan" in found[1].reason
