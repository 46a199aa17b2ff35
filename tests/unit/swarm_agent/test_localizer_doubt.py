"""Something stands beside a robot that no wall explains: who stands there, and when is it the robot that errs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, make_agent, make_agent_inputs, make_plan, make_presence

from swarm_agent.localization import hypotheses
from swarm_agent.localization.config import LpsConfig
from swarm_agent.localization.localizer import Localizer
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

STILL = ImuSample(np.zeros(2), 0.0, 0.0)
STOP = np.zeros(2)
FAR_WALL = np.array([[90.0, -5.0], [91.0, -5.0], [91.0, 5.0], [90.0, 5.0]])
WALL = np.array([[-30.0, 0.0], [30.0, 0.0], [30.0, 1.0], [-30.0, 1.0]])
BESIDE = np.array([[0.9, 0.0]])  # what is seen
SIDE = 0.3 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
BODY = SIDE + np.array([1.2, 0.0])
OTHER = NodeId(7)
NOBODY: dict[NodeId, Presence] = {}
CONFIG = LpsConfig()
PASSING_S, STAYING_S = 5.0, 20.0  # so long does who fell silent on its way, or at rest, hide a wall


class Robot:
    """A robot at rest in the origin that ranges to nobody unless told otherwise."""

    def __init__(
        self, period: float = 0.5, wall: FloatArray = FAR_WALL, y: float = 0.0, sigma: float = 0.1, **settings: float
    ) -> None:
        config = replace(CONFIG, **settings)  # type: ignore[arg-type]
        self.localizer = Localizer(config, period, PositionFix(np.array([0.0, y]), sigma), (wall,))
        self.period, self.tick = period, -1
        self.sigma, self.position = sigma, np.zeros(2)

    def stay(
        self,
        seconds: float,
        neighbors: dict[NodeId, Presence] = NOBODY,
        *,
        is_blocked: bool = True,
        seen: FloatArray = BESIDE,
        distance: float | None = None,
    ) -> float:
        """Return the standard deviation of the position after a while beside what is `seen`."""
        for _ in range(round(seconds / self.period)):
            self.tick += 1
            heard = {robot: replace(presence, tick=self.tick) for robot, presence in neighbors.items()}
            ranges = [] if distance is None else [distance] * len(heard)
            scan = RangeScan(np.array(list(heard)[: len(ranges)], dtype=np.int64), np.array(ranges))
            estimate = self.localizer.step(
                self.tick, STILL, None, scan, heard, proximity=seen, told=STOP, is_blocked=is_blocked
            )
            assert estimate is not None
            self.sigma, self.position = hypotheses.widest(estimate.covariance), estimate.position
        return self.sigma


@pytest.mark.parametrize("period", [0.05, 0.5, 1.0])
def test_who_is_blocked_by_what_nothing_explains_doubts_itself_at_the_same_pace_whatever_the_period(
    period: float,
) -> None:
    robot = Robot(period)

    assert robot.stay(CONFIG.walls_after_s + CONFIG.doubt_after_s) < 0.15
    assert robot.stay(4.0) == pytest.approx((4.0 * CONFIG.doubt_m2_per_s) ** 0.5, abs=0.12)


def test_doubt_ends_at_its_bound() -> None:
    robot = Robot()

    assert robot.stay(60.0) == pytest.approx(CONFIG.doubt_sigma_max_m, abs=0.02)
    assert robot.stay(60.0) < CONFIG.lost.sigma_max_m  # a robot is not lost for an obstacle that no map has


@pytest.mark.parametrize("period", [0.05, 0.5])
def test_who_stands_where_it_wants_to_stand_has_no_doubt_beside_anything(period: float) -> None:
    assert Robot(period).stay(120.0, is_blocked=False) < 0.25


def test_doubt_can_be_switched_off() -> None:
    assert Robot(doubt_m2_per_s=0.0).stay(60.0) < 0.2


def test_what_was_explained_in_between_starts_the_wait_anew() -> None:
    robot = Robot()
    for _ in range(10):
        robot.stay(CONFIG.doubt_after_s)
        robot.stay(1.0, seen=np.empty((0, 2)))

    assert robot.sigma < 0.2


def test_doubt_is_the_robots_own_and_no_error_that_neighbors_share() -> None:
    robot = Robot()
    robot.stay(20.0)
    belief = hypotheses.merged(robot.localizer._hypotheses)

    assert belief.shared == 0.0


def test_bodies_of_the_plan_explain_what_is_seen_of_them() -> None:
    knows, elsewhere = Robot(), Robot()
    knows.localizer.learn((), (SIDE + 50.0, BODY))
    elsewhere.localizer.learn((), (SIDE + 50.0,))

    assert knows.stay(60.0) < 0.2
    assert elsewhere.stay(60.0) > 0.8


def test_a_plan_without_bodies_takes_them_back() -> None:
    robot = Robot()
    robot.localizer.learn((), (BODY,))
    robot.localizer.learn((), ())

    assert robot.stay(60.0) > 0.8


def test_who_fell_silent_at_rest_explains_what_stands_there_for_good() -> None:
    robot = Robot()
    robot.stay(10.0, {OTHER: make_presence(1.2, 0.0, 0.1)})

    assert robot.stay(10.0 * STAYING_S) < 0.3


def test_who_is_heard_from_elsewhere_explains_its_old_place_no_more() -> None:
    robot = Robot()
    robot.stay(10.0, {OTHER: make_presence(1.2, 0.0, 0.1)})
    robot.stay(STAYING_S + 5.0)
    robot.stay(1.0, {OTHER: make_presence(20.0, 0.0, 0.1)})

    assert robot.stay(STAYING_S - 2.0) > 0.8


def test_who_fell_silent_on_its_way_explains_only_for_a_moment() -> None:
    robot = Robot()
    passing = make_presence(1.2, 0.0, 0.1, velocity=np.array([0.3, 0.0]))
    robot.stay(10.0, {OTHER: passing})

    assert robot.stay(PASSING_S + CONFIG.doubt_after_s) < 0.2
    assert robot.stay(60.0) > 0.8


def test_last_words_of_a_robot_that_did_not_know_its_place_explain_nothing() -> None:
    robot = Robot()
    robot.stay(10.0, {OTHER: make_presence(1.2, 0.0, SIGMA_UNKNOWN)}, is_blocked=False)

    assert robot.stay(STAYING_S + 5.0, is_blocked=False) < 0.2
    assert robot.stay(20.0) > 0.8


def before_the_wall(
    presence: Presence, silent_s: float = 0.0, distance: float | None = None, heard_s: float = 20.0
) -> float:
    """Return where a robot 2 m before the wall, that believes to be 0.4 m nearer, finds itself."""
    robot = Robot(wall=WALL, y=-1.6, sigma=0.5)
    ahead = np.array([[0.0, 2.0]])
    robot.stay(heard_s, {OTHER: presence}, is_blocked=False, seen=ahead, distance=distance)
    if silent_s:
        robot.stay(silent_s, is_blocked=False, seen=ahead)
    return float(robot.position[1])


def test_a_wall_stays_hidden_behind_a_robot_that_fell_silent_only_for_a_while() -> None:
    parked = make_presence(0.0, 0.4, 0.1)
    passing = replace(parked, velocity=np.array([0.3, 0.0]))

    assert before_the_wall(passing, PASSING_S - 1.0) == pytest.approx(-1.6, abs=0.05)
    assert before_the_wall(passing, PASSING_S + 3.0) == pytest.approx(-2.0, abs=0.05)
    assert before_the_wall(parked, STAYING_S - 1.0) == pytest.approx(-1.6, abs=0.05)
    assert before_the_wall(parked, STAYING_S + 3.0) == pytest.approx(-2.0, abs=0.05)


def test_who_does_not_know_where_it_is_hides_no_wall_unless_its_range_says_that_it_may_be_near() -> None:
    lost = make_presence(0.0, 0.0, SIGMA_UNKNOWN, is_beacon=False)

    assert before_the_wall(lost) == pytest.approx(-2.0, abs=0.05)
    assert before_the_wall(lost, distance=20.0) == pytest.approx(-2.0, abs=0.05)
    assert before_the_wall(lost, distance=2.5) == pytest.approx(-1.6, abs=0.05)


def test_without_a_map_of_its_own_a_robot_takes_the_walls_of_the_plan_for_landmarks() -> None:
    seen = np.array([[0.0, 2.0]])
    found = []
    for own, walls, bodies in (((), (WALL,), ()), ((), (), (WALL,)), ((FAR_WALL,), (WALL,), ())):
        localizer = Localizer(CONFIG, 0.5, PositionFix(np.array([0.0, -1.6]), 0.5), own)
        localizer.learn(walls, bodies)
        for tick in range(20):
            scan = RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0))
            estimate = localizer.step(tick, STILL, None, scan, NOBODY, proximity=seen, told=STOP)
        assert estimate is not None
        found.append(float(estimate.position[1]))

    assert found[0] == pytest.approx(-2.0, abs=0.05)
    assert found[1:] == pytest.approx([-1.6, -1.6], abs=0.01)


def test_an_agent_started_without_a_map_finds_its_place_by_the_walls_of_the_plan_and_not_by_bodies() -> None:
    """Its position sensor has told it 0.4 m too much once, and is silent from then on."""
    found = []
    for bodies in (0, 1):
        agent, mission = make_agent(), MeshNetwork(MISSION, NetworkConfig(), PERIOD)
        plan = replace(make_plan(np.array([[0.0, -2.0]])), obstacles=(WALL,), bodies=bodies)
        mission.flood(encode_body(plan))
        presence = make_presence(0.0, -50.0, robot_type=0, is_beacon=False)
        for tick in range(20):
            outputs = agent.step(
                make_agent_inputs(
                    tick,
                    fix=PositionFix(np.array([0.0, -1.6]), 0.3) if tick == 0 else None,
                    proximity=np.array([[0.0, 2.0]]),
                    inbox=mission.transmit(tick, replace(presence, tick=tick)),
                )
            )
        assert outputs.report.epoch == plan.epoch
        found.append(abs(float(outputs.report.position[1]) + 2.0))

    assert found[0] < 0.1
    assert found[1] > 0.3
