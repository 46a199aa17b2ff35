"""A robot that only knows from the mission computer's broadcasts where it is, and which way it faces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from builders import make_agent_inputs

from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_agent.control.config import ControlConfig
from swarm_agent.control.facing import Facing
from swarm_agent.localization.camera_fixes import AGE_TICKS_MAX, CameraFixReceiver, SeenFrom, Trail
from swarm_agent.localization.config import LpsConfig
from swarm_agent.localization.localizer import Localizer
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.frames import encode_frame
from swarm_msgs_py.messages.bodies import CameraFixes
from swarm_msgs_py.messages.radio import Delivery, Packet
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.messages.sensing import ImuSample, PoseFix, RangeScan
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.step_io import AgentOutputs
from swarm_msgs_py.types import EVERYONE, MISSION, NodeId

DT = 0.1
ROBOT = NodeId(1)
LPS = LpsConfig(from_camera=True, wall_sigma_m=None, command_sigma_mps=0.004, blind_after_s=0.5)
TYPE = RobotType(type=1, mass_kg=1.0, mu1=0.5, mu2=0.1, coverage_radius_m=0.1)
NO_COMPASS = ImuSample(np.zeros(2), None, 0.0)
NO_SCAN = RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0))


def fix(x: float, y: float = 0.0, yaw: float = 0.0, robot: NodeId = ROBOT) -> PoseFix:
    return PoseFix(robot, np.array([x, y]), yaw, 0.001, 0.002)


def told(tick: int, *fixes: PoseFix, origin: NodeId = MISSION) -> Delivery:
    return Delivery(origin, encode_body(CameraFixes(tick, fixes)))


def test_a_robot_takes_its_own_row_of_the_newest_image() -> None:
    receiver = CameraFixReceiver(ROBOT)

    found = receiver.take(5, [told(4, fix(1.0), fix(2.0, robot=NodeId(2))), told(3, fix(0.5))])

    assert found is not None
    assert (found.tick, found.fix.position[0]) == (4, 1.0)
    assert receiver.seen_at == 4


def test_an_image_counts_once_and_none_goes_back() -> None:
    receiver = CameraFixReceiver(ROBOT)
    receiver.take(5, [told(4, fix(1.0))])

    assert receiver.take(6, [told(4, fix(1.0)), told(3, fix(0.5))]) is None


@pytest.mark.parametrize(
    "delivery",
    [
        told(4, fix(1.0), origin=NodeId(7)),
        told(6, fix(1.0)),
        told(4, fix(1.0, robot=NodeId(2))),
        Delivery(MISSION, b"\xff nonsense"),
    ],
    ids=["of another robot", "of the future", "of somebody else", "damaged"],
)
def test_what_the_camera_did_not_say_of_this_robot_is_no_fix(delivery: Delivery) -> None:
    assert CameraFixReceiver(ROBOT).take(5, [delivery]) is None


def test_a_fix_that_is_too_old_is_of_no_use() -> None:
    assert CameraFixReceiver(ROBOT).take(AGE_TICKS_MAX + 4, [told(4, fix(1.0))]) is None


def test_a_trail_sums_up_what_came_after() -> None:
    trail = Trail(3)
    for tick in range(6):
        trail.note(tick, np.array([1.0, float(tick)]))

    assert trail.since(3).tolist() == [2.0, 9.0]
    assert trail.since(-1).tolist() == [3.0, 12.0]  # no more is remembered
    assert not trail.since(5).any()


def test_an_old_fix_is_brought_forward_by_the_way_driven_since() -> None:
    localizer, speed = Localizer(LPS, DT), np.array([0.05, 0.0])
    heading = ImuSample(np.zeros(2), 0.0, 0.0)
    pushed = ImuSample(speed / DT, 0.0, 0.0)

    def step(tick: int, imu: ImuSample, seen: SeenFrom | None) -> float:
        told_to = None if tick == 0 else speed
        estimate = localizer.step(tick, imu, None, NO_SCAN, {}, told=told_to, seen=seen)
        return math.nan if estimate is None else float(estimate.position[0])

    step(0, heading, SeenFrom(0, fix(0.0)))
    reckoned = [step(tick, pushed if tick == 1 else heading, None) for tick in range(1, 9)]
    late = step(9, heading, SeenFrom(5, fix(reckoned[4])))

    assert late == pytest.approx(reckoned[-1] + 0.05 * DT, abs=2e-4)
    assert not localizer.is_beacon  # nobody may range to it as if it had a sensor of its own


class Arena:
    """One robot that hears a mission computer: frames in, answers out."""

    def __init__(self, **control: float) -> None:
        config = AgentConfig(lps=LPS, control=ControlConfig(**control))  # type: ignore[arg-type]
        self.agent = Agent(ROBOT, config, TYPE, DT)
        self.tick = -1

    def step(self, seen: CameraFixes | None = None, proximity: np.ndarray | None = None) -> AgentOutputs:
        self.tick += 1
        frames: tuple[bytes, ...] = ()
        if seen is not None:
            packet = Packet(MISSION, self.tick, EVERYONE, MISSION, EVERYONE, self.tick, 3, encode_body(seen))
            frames = (encode_frame(packet),)
        inputs = make_agent_inputs(self.tick, imu=NO_COMPASS, fix=None, inbox=frames)
        inputs = replace(inputs, time=self.tick * DT)
        return self.agent.step(inputs if proximity is None else replace(inputs, proximity=proximity))


def test_without_a_word_of_the_camera_a_robot_knows_nothing_and_stands_still() -> None:
    arena = Arena()
    answers = [arena.step() for _ in range(30)]

    assert all(answer.report.mode is Mode.WAITING for answer in answers)
    assert not any(
        (answer.command.forward, answer.command.left, answer.command.yaw_rate) != (0, 0, 0) for answer in answers
    )


def test_one_image_tells_place_and_heading() -> None:
    arena = Arena()
    arena.step()
    report = arena.step(CameraFixes(0, (fix(0.3, -0.2, 1.0),))).report

    assert report.position == pytest.approx([0.3, -0.2], abs=1e-3)
    assert report.yaw == pytest.approx(1.0, abs=1e-3)


def test_a_robot_that_is_not_seen_for_long_stops_and_goes_on_when_it_is() -> None:
    arena = Arena(heading_deg=90.0)  # it has something to do: it turns
    for tick in range(3):
        answer = arena.step(CameraFixes(tick, (fix(0.3),)))
    assert answer.command.yaw_rate > 0.0

    unseen = [arena.step() for _ in range(15)]
    turning = [answer.command.yaw_rate > 0.0 for answer in unseen]

    assert turning == [True] * 5 + [False] * 10
    assert {answer.report.mode for answer in unseen[5:]} == {Mode.BLIND}
    again = arena.step(CameraFixes(arena.tick, (fix(0.3, yaw=0.2),)))
    assert again.command.yaw_rate > 0.0
    assert again.report.mode is not Mode.BLIND


def test_a_blind_robot_still_backs_out_of_what_comes_too_near() -> None:
    arena = Arena()
    for tick in range(3):
        arena.step(CameraFixes(tick, (fix(0.3),)))
    for _ in range(10):
        answer = arena.step()
    assert answer.report.mode is Mode.BLIND

    answer = arena.step(proximity=np.array([[0.105, 0.0]]))  # 5 mm from its rim
    assert answer.command.forward < 0.0


def test_a_robot_faces_as_ordered_and_keeps_to_it() -> None:
    facing = Facing(ControlConfig(heading_deg=None, heading_gain_1_s=0.5, turn_max_rps=0.4))

    assert facing.turn_rate(0.7, None) == 0.0  # the first heading is held
    assert facing.turn_rate(0.8, None) == pytest.approx(-0.05)
    assert facing.turn_rate(0.8, 1.0) == pytest.approx(0.1)
    assert facing.turn_rate(0.8, None) == pytest.approx(0.1)  # an order stays in force
    assert facing.turn_rate(-3.0, 3.0) == pytest.approx(-0.5 * (math.tau - 6.0))  # the short way around
    assert facing.turn_rate(0.0, 3.0) == 0.4
