import numpy as np
import pytest
from mission_air import PERIOD, SQUARE, Air, Radio

from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from mission_computer.shape import load_shape
from swarm_msgs_py.messages.bodies import Plan, RowRequest, Task
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import EVERYONE, MISSION, FloatArray

BOUNDS = (-30.0, -30.0, 30.0, 30.0)
WALL = np.array([[10.1, 0.0], [11.0, 0.0], [11.0, 3.0]])
ROSTER = Roster.of([*THESIS_TYPES, THESIS_TYPES[0]])


def make_mission(shape: FloatArray = SQUARE, task: Task = Task.GOALS) -> Mission:
    return Mission(MissionConfig(task=task), NetworkConfig(), ROSTER, (WALL,), shape, PERIOD, BOUNDS)


def test_the_first_step_plans_the_first_shape() -> None:
    outputs = Air(make_mission()).step()

    assert outputs.plan is not None
    assert outputs.plan.epoch == outputs.report.epoch == 1
    assert sorted(outputs.plan.goal_types) == [1, 1, 2, 3]
    assert len(outputs.plan.goals) == 4


def test_the_plan_is_handed_out_only_in_the_tick_in_which_it_changed() -> None:
    air = Air(make_mission())
    air.step()

    assert air.step().plan is None


def test_a_robot_hears_exactly_the_numbers_that_viewers_see() -> None:
    radio = Radio(0)
    air = Air(make_mission(load_shape("hw_3_pentagon", scale=9.7)), radio)

    published = air.step().plan
    air.run(3)

    assert published is not None
    (heard,) = radio.plans
    for mine, theirs in zip(
        (published.contour, published.goals, published.goal_types, *published.obstacles),
        (heard.contour, heard.goals, heard.goal_types, *heard.obstacles),
        strict=True,
    ):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("task", [task for task in Task if task is not Task.GOALS])
def test_what_is_left_to_the_robots_is_not_told_them_but_shown_to_viewers(task: Task) -> None:
    radio = Radio(0)
    air = Air(make_mission(task=task), radio)

    shown = air.step().plan
    air.run(3)

    assert shown is not None
    (heard,) = radio.plans
    assert (heard.task, heard.roster, heard.goals_crc) == (task, ROSTER, shown.goals_crc)
    assert (len(heard.goals), len(shown.goals)) == (0, 4 if task.has_goals else 0)


def test_the_plan_is_repeated_until_the_robot_reports_it() -> None:
    radio = Radio(0)
    air = Air(make_mission(), radio)
    air.run(26)  # floods at 0, 5 and 12.5 s
    air.run(2)  # on the air
    repeated = len(radio.plans)

    radio.report(epoch=1)
    radio.epoch = 1
    air.run(3)
    told = len(radio.plans)
    outputs = air.run(60)

    assert repeated == 3
    assert outputs.report.informed == outputs.report.reachable == (0,)
    assert len(radio.plans) == told


def test_a_neighbor_whose_hello_carries_the_epoch_counts_as_informed() -> None:
    radio = Radio(0, epoch=1)
    air = Air(make_mission(), radio)

    outputs = air.run(30)

    assert outputs.report.informed == (0,)
    assert len(radio.plans) == 1


def test_who_asks_for_the_plan_gets_it_and_who_has_it_does_not() -> None:
    behind, current = Radio(0, epoch=1), Radio(1, epoch=1)
    air = Air(make_mission(), behind, current)
    air.run(3)
    behind.tell(RowRequest(0, ()))  # the flood has only just been sent
    air.run(9)
    before = len(behind.plans), len(current.plans)

    behind.tell(RowRequest(0, ()))
    current.tell(RowRequest(1, ()))
    air.run(6)

    assert before == (1, 1)
    assert (len(behind.plans), len(current.plans)) == (2, 1)


def test_a_new_shape_becomes_the_next_plan() -> None:
    air = Air(make_mission(), Radio(0))
    air.run(3)

    outputs = air.step(SQUARE + 20.0)

    assert outputs.plan is not None
    assert outputs.plan.epoch == 2
    assert outputs.plan.goals.min() > 20.0
    assert outputs.report.informed == ()


BAD_SHAPES = {
    "too small": (0.3 * SQUARE, "too small for 4 robots: needs"),
    "crossing": (SQUARE[[0, 2, 1, 3]], "crosses or touches itself at"),
    "over the wall": (SQUARE + np.array([8.0, 0.0]), r"obstacle 1 at \(10\.7, 1\.0\) covers"),
    "not finite": (SQUARE + np.array([0.0, np.nan]), "must be a finite number"),
    "outside": (SQUARE + np.array([24.5, 0.0]), r"vertex \(30\.5, [06]\) is 0\.5 m outside the arena"),
    "empty": (np.empty((0, 2)), "at least 3"),
}


@pytest.mark.parametrize(("shape", "complaint"), BAD_SHAPES.values(), ids=BAD_SHAPES)
def test_a_refused_shape_leaves_the_plan_and_says_why(shape: FloatArray, complaint: str) -> None:
    air = Air(make_mission())
    air.step()

    outputs = air.step(shape)

    assert outputs.plan is None
    assert outputs.report.epoch == 1
    with pytest.raises(AssertionError, match=f"^shape refused: .*{complaint}.*plan 1 stays in force$"):
        raise AssertionError(outputs.report.notice)
    assert air.step().report.notice == ""


def test_a_refused_first_shape_leaves_no_plan_and_a_good_one_may_follow() -> None:
    air = Air(make_mission(0.2 * SQUARE))

    first, second = air.step(), air.step(SQUARE)

    assert first.report.epoch == 0
    assert "there is no plan yet" in first.report.notice
    assert second.report.epoch == 1


def test_a_restarted_mission_computer_overtakes_the_plan_that_the_robots_hold() -> None:
    radio = Radio(0, epoch=7)
    air = Air(make_mission(), radio)

    outputs = [air.step() for _ in range(6)]

    assert outputs[-1].report.epoch == 8
    assert [o.plan.epoch for o in outputs if o.plan is not None] == [1, 8]
    assert [plan.epoch for plan in radio.plans] == [1, 8]


def test_robots_that_report_to_be_parked_are_listed_while_the_plan_stands() -> None:
    radios = [Radio(3), Radio(1), Radio(2)]
    air = Air(make_mission(), *radios)
    air.run(8)

    for radio, mode in zip(radios, (Mode.PARKED, Mode.PARKED, Mode.TRAVELING), strict=True):
        radio.report(epoch=1, mode=mode)
    parked = air.run(3).report.parked

    assert parked == (1, 3)
    assert air.step(SQUARE + 20.0).report.parked == ()


def test_bodies_that_are_not_one_are_counted_and_dropped() -> None:
    radio = Radio(0)
    air = Air(make_mission(), radio)
    air.run(4)

    radio.mesh.flood(b"\xff\x00nonsense")
    outputs = air.run(3)

    assert outputs.report.counters.corrupt == 1


def plans_and_notices(air: Air, ticks: int) -> tuple[list[Plan], list[str]]:
    outputs = [air.step() for _ in range(ticks)]
    return [o.plan for o in outputs if o.plan is not None], [o.report.notice for o in outputs if o.report.notice]


@pytest.mark.parametrize("task", list(Task))
def test_a_robot_that_falls_silent_for_good_is_planned_around(task: Task) -> None:
    air = Air(make_mission(task=task), Radio(0), Radio(7))
    first = air.step().plan
    air.run(9)
    air.radios[1].report(epoch=1)
    air.run(2)

    air.radios = air.radios[:1]
    before = plans_and_notices(air, 40)  # 20 s: the mesh has forgotten the robot only later
    plans, notices = plans_and_notices(air, 40)

    assert before == ([], [])
    assert notices == ["r07 is lost; new plan for 3 robots"]
    assert first is not None
    (plan,) = plans
    assert plan.epoch == 2
    assert (plan.task, plan.robot_count) == (task, first.robot_count - 1)
    assert len(plan.goals) == (len(first.goals) - 1 if task.has_goals else 0)
    assert plan.obstacles[-1].mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-6)  # where its last hello put it


def test_a_lost_robot_that_is_heard_again_gets_its_goal_back() -> None:
    lost = Radio(7)
    air = Air(make_mission(), Radio(0), lost)
    first = air.step().plan
    air.run(5)
    air.radios = air.radios[:1]
    air.run(80)

    air.radios = (*air.radios, lost)
    plans, notices = plans_and_notices(air, 30)

    assert notices == ["r07 is back; new plan for 4 robots"]
    assert first is not None
    np.testing.assert_array_equal(plans[-1].goals, first.goals)
    assert (plans[-1].epoch, len(plans[-1].obstacles)) == (3, 1)


def test_a_short_silence_is_no_loss() -> None:
    away = Radio(7)
    air = Air(make_mission(), Radio(0), away)
    air.run(6)

    for _ in range(4):
        air.radios = air.radios[:1]
        silent = plans_and_notices(air, 30)  # 15 s
        air.radios = (*air.radios, away)
        assert (silent, plans_and_notices(air, 20)) == (([], []), ([], []))


def test_robots_that_were_never_heard_are_waited_for() -> None:
    assert plans_and_notices(Air(make_mission(), Radio(0)), 200)[1] == []


def test_when_no_plan_for_those_left_can_be_made_the_old_one_stays_and_it_is_said_once() -> None:
    air = Air(Mission(MissionConfig(), NetworkConfig(), Roster.of(THESIS_TYPES[:1]), (), SQUARE, PERIOD), Radio(0))
    air.run(6)
    air.radios = ()

    plans, notices = plans_and_notices(air, 200)

    assert plans == []
    assert notices == ["r00 is lost, but a new plan is not possible: no robot is left; plan 1 stays in force"]


def test_equal_missions_say_the_same_bytes() -> None:
    first, second = Air(make_mission(), Radio(0)), Air(make_mission(), Radio(0))

    assert [first.step().outbox for _ in range(12)] == [second.step().outbox for _ in range(12)]


def test_its_hello_shows_a_fixed_antenna_that_is_no_robot() -> None:
    radio = Radio(0)
    Air(make_mission(), radio).run(3)

    presence = radio.mesh.neighbors[MISSION]

    assert (presence.robot_type, presence.is_beacon, presence.epoch) == (0, False, 1)
    assert presence.position.tolist() == [0.0, 0.0]
    assert EVERYONE not in radio.mesh.neighbors


def test_an_absurd_epoch_in_a_hello_or_report_does_not_carry_the_count_away() -> None:
    radio = Radio(0, epoch=2**31 - 1)
    air = Air(make_mission(), radio)

    air.run(6)
    radio.report(epoch=2**32 - 1, mode=Mode.PARKED)
    outputs = air.run(4)

    assert outputs.report.epoch == 1
    assert outputs.report.parked == ()


def test_a_plan_too_large_for_a_packet_is_refused_with_its_size() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 18_000, endpoint=False)
    fence = 300.0 + 2.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    air = Air(Mission(MissionConfig(), NetworkConfig(), ROSTER, (fence,), SQUARE, PERIOD, None), Radio(0))

    outputs = air.step()

    assert outputs.plan is None
    assert "bytes; a packet carries at most" in outputs.report.notice
    assert "18000 corners" in outputs.report.notice
