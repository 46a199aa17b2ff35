"""The mission computer and its schedule: when it orders what, and what becomes of it."""

from __future__ import annotations

import numpy as np
from mission_air import PERIOD, SQUARE, Air, Radio

from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from mission_computer.stages import Stage
from swarm_msgs_py.messages.bodies import Report, Task
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import MissionOutputs

EAST = SQUARE + np.array([5.0, 0.0])
BOWTIE = np.array([[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]])
LEAD_S = 2.0


def make_mission(*stages: Stage, method: Method = Method.BUBBLE_PACKING, **settings: float) -> Mission:
    config = MissionConfig(lead_s=LEAD_S, partition=PartitionConfig(method=method), **settings)
    roster = Roster.of([THESIS_TYPES[0]] * 2)
    return Mission(config, NetworkConfig(), roster, (), SQUARE, PERIOD, (-30.0, -30.0, 30.0, 30.0), stages)


def steps(air: Air, ticks: int) -> list[MissionOutputs]:
    return [air.step() for _ in range(ticks)]


def plans(outputs: list[MissionOutputs]) -> list[tuple[int, int]]:
    """Return tick and epoch of each new plan."""
    return [(step.tick, step.plan.epoch) for step in outputs if step.plan is not None]


def stand(radio: Radio, epoch: int, mode: Mode = Mode.PARKED) -> None:
    radio.epoch = epoch
    radio.tell(Report(radio.id, 1, epoch, 0, (1.0, 2.0), int(mode), 0.1))


def test_a_stage_with_a_time_is_ordered_then_and_begins_after_the_lead() -> None:
    outputs = steps(Air(make_mission(Stage(EAST, over_s=10.0, at_s=3.0))), 8)

    assert plans(outputs) == [(0, 1), (6, 2)]
    moving = outputs[6].plan
    assert moving is not None
    assert moving.motion is not None
    assert (moving.motion.begins, moving.motion.ends) == (10, 30)
    assert [(step.report.stage, step.report.stages_left) for step in outputs[5:7]] == [(0, 1), (1, 0)]


def test_late_stages_come_one_after_the_other_as_their_motions_end() -> None:
    mission = make_mission(Stage(EAST, over_s=10.0, at_s=3.0), Stage(SQUARE, over_s=10.0, at_s=5.0))
    air = Air(mission)
    air.tick = 100  # the mission computer has been restarted

    outputs = steps(air, 60)

    assert plans(outputs) == [(100, 1), (101, 2), (125, 3)]
    first, second = (step.plan for step in outputs if step.plan is not None and step.plan.motion is not None)
    assert first is not None
    assert second is not None
    assert first.motion is not None
    assert second.motion is not None
    assert second.motion.begins - first.motion.ends == round(LEAD_S / PERIOD)
    np.testing.assert_array_equal(second.motion.start, first.contour)


def test_a_stage_without_a_time_waits_until_all_report_that_they_are_at_rest() -> None:
    one, two = Radio(1), Radio(2)
    air = Air(make_mission(Stage(EAST, hold_s=1.0)), one, two)
    before = steps(air, 4)
    stand(one, 1)
    stand(two, 1, Mode.TRAVELING)
    before += steps(air, 8)
    assert plans(before) == [(0, 1)]

    stand(two, 1)
    after = steps(air, 6)

    ((tick, epoch),) = plans(after)
    heard = next(step.tick for step in after if step.report.parked == (1, 2))
    assert (tick, epoch) == (heard + 2, 2)


def test_a_swarm_of_whom_nobody_has_been_heard_is_not_at_rest() -> None:
    air = Air(make_mission(Stage(EAST), lost_after_s=3.0))

    assert plans(steps(air, 40)) == [(0, 1)]


def test_a_robot_that_was_never_heard_is_not_waited_for_for_ever() -> None:
    one = Radio(1)
    air = Air(make_mission(Stage(EAST), lost_after_s=6.0), one)
    steps(air, 4)
    stand(one, 1)

    (ordered,) = plans(steps(air, 20))

    assert ordered == (12, 2)


def test_a_stage_that_cannot_be_had_breaks_the_schedule_off() -> None:
    mission = make_mission(Stage(EAST, over_s=5.0, at_s=1.0), Stage(EAST, at_s=4.0), method=Method.FRACTALS)

    outputs = steps(Air(mission), 12)

    assert plans(outputs) == [(0, 1)]
    notices = [step.report.notice for step in outputs if step.report.notice]
    assert len(notices) == 1
    assert notices[0].startswith("stage 1 refused: ")
    assert notices[0].endswith("plan 1 stays in force")
    last = outputs[-1].report
    assert (last.stage, last.stages_left, last.is_broken_off) == (0, 2, True)


def test_an_order_of_the_operator_becomes_a_motion_if_that_is_wanted_and_ends_the_schedule() -> None:
    air = Air(make_mission(Stage(SQUARE, at_s=8.0), morph_s=6.0))
    steps(air, 4)

    plan = air.step(shape=EAST).plan
    later = steps(air, 20)

    assert plan is not None
    assert plan.motion is not None
    assert (plan.motion.begins, plan.motion.ticks, plan.follows) == (8, 12, 1)
    assert plans(later) == []
    assert (later[-1].report.stages_left, later[-1].report.is_broken_off) == (0, False)


def test_an_order_that_cannot_be_used_is_refused_and_the_motion_goes_on() -> None:
    air = Air(make_mission(Stage(EAST, over_s=10.0, at_s=1.0), Stage(SQUARE, at_s=20.0), morph_s=6.0))
    steps(air, 6)

    refused = air.step(shape=BOWTIE)

    assert refused.plan is None
    assert refused.report.notice.startswith("shape refused: ")
    assert (refused.report.epoch, refused.report.stages_left) == (2, 1)


def test_after_a_loss_in_mid_motion_the_rest_is_planned_for_those_who_are_left() -> None:
    one, two = Radio(1), Radio(2)
    air = Air(make_mission(Stage(EAST, over_s=30.0, at_s=1.0), lost_after_s=4.0, regroup_wait_s=0.0), one, two)
    steps(air, 3)
    stand(one, 2, Mode.TRAVELING)
    stand(two, 2, Mode.TRAVELING)
    steps(air, 4)
    air.radios = (one,)

    outputs = steps(air, 40)

    ((tick, epoch),) = plans(outputs)
    plan = next(step.plan for step in outputs if step.plan is not None)
    assert (epoch, len(plan.goals)) == (3, 1)
    assert plan.motion is not None
    assert plan.motion.begins == tick + round(LEAD_S / PERIOD)
    assert plan.motion.start[:, 0].min() > 0.1  # on its way
    np.testing.assert_array_equal(plan.contour, EAST)


def test_plans_of_forces_move_likewise() -> None:
    config = MissionConfig(task=Task.FORCES, lead_s=LEAD_S)
    roster, stage = Roster.of([THESIS_TYPES[0]] * 2), Stage(EAST, over_s=10.0, at_s=1.0)
    air = Air(Mission(config, NetworkConfig(), roster, (), SQUARE, PERIOD, stages=[stage]), Radio(1))

    plan = steps(air, 3)[2].plan

    assert plan is not None
    assert plan.motion is not None
    assert (len(plan.goals), plan.follows, plan.robot_count) == (0, 0, 2)
