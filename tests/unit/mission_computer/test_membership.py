from dataclasses import replace

import numpy as np
import pytest
from builders import make_presence

from mission_computer.config import MissionConfig
from mission_computer.membership import Membership, change_line
from swarm_msgs_py.messages.bodies import Report
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import NodeId

CONFIG = MissionConfig(lost_after_s=20.0, regroup_wait_s=3.0, regroup_pause_s=10.0)


@pytest.fixture
def membership() -> Membership:
    return Membership(CONFIG, (1, 2))


def report(robot: int, robot_type: int = 1, position: tuple[float, float] = (1.0, 2.0), sigma: float = 0.1) -> Report:
    return Report(NodeId(robot), robot_type, 1, 0, position, 0, sigma)


def presence(x: float, sigma: float = 0.02, robot_type: int = 1) -> Presence:
    return make_presence(x, sigma=sigma, robot_type=robot_type, epoch=1)


def lost(membership: Membership, time: float) -> list[int]:
    return [member.robot for member in membership.lost(time)]


def due_times(membership: Membership, begin: float, end: float) -> list[float]:
    """Account whenever it is due, and return when that was, at two ticks a second."""
    times = []
    for time in np.arange(begin, end, 0.5):
        if membership.is_regrouping_due(time):
            membership.account(time)
            times.append(float(time))
    return times


def test_a_robot_that_reported_is_lost_after_its_silence(membership: Membership) -> None:
    membership.take_report(report(7), 5.0)

    assert lost(membership, 24.5) == []
    assert lost(membership, 25.0) == [7]


def test_a_robot_to_which_there_is_a_route_is_not_lost(membership: Membership) -> None:
    membership.take_report(report(7), 0.0)
    membership.take_routes((NodeId(7),), 30.0)

    assert lost(membership, 49.5) == []
    assert lost(membership, 50.0) == [7]


def test_a_robot_that_was_never_heard_is_expected_not_lost(membership: Membership) -> None:
    membership.take_routes((NodeId(3),), 0.0)

    assert lost(membership, 1000.0) == []


def test_a_neighbor_that_never_reported_can_be_lost_too(membership: Membership) -> None:
    membership.take_presence(NodeId(2), presence(1.5), 0.0)

    (member,) = membership.lost(20.0)

    assert (member.robot, member.type, member.position, member.goal) == (2, 1, (1.5, 0.0), -1)


def test_the_freshest_position_counts(membership: Membership) -> None:
    membership.take_report(report(2), 0.0)
    membership.take_presence(NodeId(2), presence(1.5, sigma=0.3), 1.0)

    assert [(one.position, one.epoch, one.goal, one.sigma) for one in membership.lost(50.0)] == [
        ((1.5, 0.0), 1, 0, 0.3)
    ]


def test_of_a_robot_that_does_not_know_where_it_is_nobody_knows_where_its_body_stands(membership: Membership) -> None:
    membership.take_report(report(2), 0.0)
    membership.take_presence(NodeId(2), presence(9.0, sigma=2.0), 2.0)
    membership.take_report(report(3, sigma=0.2), 0.0)
    membership.take_report(report(3, sigma=20.0), 2.0, np.array([5.0, 5.0]))

    assert [(one.position, one.ahead, one.goal) for one in membership.lost(50.0)] == [(None, None, 0)] * 2


def test_who_claims_a_type_that_the_roster_lacks_is_no_member(membership: Membership) -> None:
    membership.take_report(report(9, robot_type=200), 0.0)
    membership.take_presence(NodeId(0xFFF0), presence(1.0, robot_type=0), 0.0)

    assert lost(membership, 100.0) == []


def test_a_lost_robot_that_speaks_again_is_back(membership: Membership) -> None:
    membership.take_report(report(7), 0.0)
    assert lost(membership, 30.0) == [7]

    membership.take_report(report(7), 30.5)

    assert lost(membership, 30.5) == []


def test_losses_that_follow_each_other_are_acted_on_together(membership: Membership) -> None:
    membership.take_report(report(1), 0.0)
    membership.take_report(report(2), 2.0)

    assert due_times(membership, 0.0, 100.0) == [25.0]  # lost at 20 and 22 s, then 3 s of waiting
    assert membership.accounted == {1, 2}


def test_two_regroupings_are_some_time_apart(membership: Membership) -> None:
    membership.take_report(report(1), 0.0)
    membership.take_report(report(2), 5.0)

    assert due_times(membership, 0.0, 100.0) == [23.0, 33.0]


def test_a_loss_that_turns_out_to_be_none_while_waiting_is_not_acted_on(membership: Membership) -> None:
    membership.take_report(report(1), 0.0)
    before = due_times(membership, 0.0, 22.0)
    membership.take_report(report(1), 22.0)

    assert (before, due_times(membership, 22.0, 40.0)) == ([], [])


def test_a_return_is_acted_on_like_a_loss(membership: Membership) -> None:
    membership.take_report(report(1), 0.0)
    assert due_times(membership, 0.0, 40.0) == [23.0]

    membership.take_report(report(1), 40.0)

    assert due_times(membership, 40.0, 60.0) == [43.0]
    assert membership.accounted == set()


@pytest.mark.parametrize(
    ("now", "before", "line"),
    [
        ({7}, (), "r07 is lost"),
        ({3, 7}, (), "r03 and r07 are lost"),
        ({1, 2, 3, 7}, {7}, "r01, r02 and r03 are lost"),
        ((), {7}, "r07 is back"),
        ({3}, {5, 7}, "r03 is lost, r05 and r07 are back"),
        (range(12), (), "r00, r01, r02 and 9 more are lost"),
    ],
)
def test_who_went_and_who_came_is_said_in_one_line(now: set[NodeId], before: set[NodeId], line: str) -> None:
    assert change_line(now, before) == line


def test_a_robot_that_drove_may_have_got_farther_than_it_said(membership: Membership) -> None:
    membership.take_report(report(1), 0.0, np.array([1.0, 9.0]))
    membership.take_report(report(2), 0.0, np.array([1.0, 2.3]))
    membership.take_report(replace(report(3), mode=int(Mode.PARKED)), 0.0, np.array([1.0, 2.3]))
    membership.take_report(report(4), 0.0)

    ahead = [member.ahead for member in membership.lost(60.0)]

    assert ahead == [(1.0, 2.0 + MissionConfig().body_drift_m), (1.0, 2.3), None, None]
