"""What a robot's commands, the walls around it and several hypotheses tell it beside its ranges."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from builders import make_presence

from swarm_agent.localization import hypotheses
from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.localizer import Localizer
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, NodeId

DT = 0.5
WALLS_AFTER = round(LpsConfig().walls_after_s / DT)  # ticks
STILL = ImuSample(np.zeros(2), 0.0, 0.0)
NO_RANGES = RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0))
STOP = np.zeros(2)
WALL = np.array([[-30.0, 0.0], [30.0, 0.0], [30.0, 1.0], [-30.0, 1.0]])
BELOW = np.array([0.0, -2.0])
ABOVE_ME = np.array([[0.0, 2.0]])
NOBODY: dict[NodeId, Presence] = {}


def told(x: float, y: float, sigma: float) -> PositionFix:
    return PositionFix(np.array([x, y]), sigma)


def after(
    localizer: Localizer, ticks: int, command: FloatArray | None = None, imu: ImuSample = STILL, begin: int = 0
) -> Estimate:
    for tick in range(begin, begin + ticks):
        estimate = localizer.step(tick, imu, None, NO_RANGES, NOBODY, told=command)
    assert estimate is not None
    return estimate


def widest_of(estimate: Estimate) -> float:
    return hypotheses.widest(estimate.covariance)


def test_a_robot_that_was_told_to_stand_drifts_no_more() -> None:
    silent, commanded = (after(Localizer(LpsConfig(), DT, told(0, 0, 0.1)), 120, c) for c in (None, STOP))

    assert widest_of(commanded) < 0.25
    assert widest_of(silent) > 2.0


def test_what_an_accelerometer_makes_up_is_no_motion() -> None:
    drifting = ImuSample(np.array([5e-3, 0.0]), 0.0, 0.0)

    silent, commanded = (after(Localizer(LpsConfig(), DT, told(0, 0, 0.1)), 120, c, drifting) for c in (None, STOP))

    assert silent.position[0] > 5.0
    assert abs(commanded.position[0]) < 0.5
    assert abs(commanded.velocity[0]) < 0.02


def test_a_push_is_noticed_although_the_command_says_otherwise() -> None:
    localizer = Localizer(LpsConfig(), DT, told(0, 0, 0.1))
    after(localizer, 20, STOP)

    after(localizer, 1, STOP, ImuSample(np.array([1.0, 0.0]), 0.0, 0.0), begin=20)
    estimate = after(localizer, 6, STOP, begin=21)

    assert estimate.velocity[0] == pytest.approx(0.5, abs=0.05)
    assert estimate.position[0] == pytest.approx(0.5 * (DT - LpsConfig().push_delay_s) + 6 * 0.5 * DT, abs=0.15)


def test_a_command_that_has_just_changed_says_little_yet() -> None:
    """The servo needs its time; a robot that still coasts is no robot that was pushed."""
    localizer = Localizer(LpsConfig(), DT, told(0, 0, 0.1))
    after(localizer, 1, STOP)
    after(localizer, 1, np.array([0.5, 0.0]), ImuSample(np.array([0.98, 0.0]), 0.0, 0.0), begin=1)

    estimate = after(localizer, 1, np.array([0.5, 0.0]), ImuSample(np.array([0.02, 0.0]), 0.0, 0.0), begin=2)

    assert estimate.velocity[0] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    "config", [LpsConfig(command_sigma_mps=None), LpsConfig(mode=LpsMode.LITERAL)], ids=["null", "literal"]
)
def test_commands_can_be_left_out_and_are_never_used_by_the_literal_mode(config: LpsConfig) -> None:
    one, other = (after(Localizer(config, DT, told(0, 0, 0.1)), 60, c) for c in (None, np.array([0.3, -0.2])))

    assert one.position.tobytes() == other.position.tobytes()
    assert one.covariance.tobytes() == other.covariance.tobytes()


def beside_the_wall(
    config: LpsConfig,
    neighbors: dict[NodeId, Presence],
    ticks: int = 2 * WALLS_AFTER,
    later: dict | None = None,  # type: ignore[type-arg]
) -> Estimate:
    """Return the belief of a robot that sees the wall 2 m ahead, and believes to be 0.4 m nearer to it."""
    localizer = Localizer(config, DT, told(0.0, -1.6, 0.5), (WALL,))
    for tick in range(ticks):
        heard = neighbors if later is None or tick < WALLS_AFTER else later
        estimate = localizer.step(tick, STILL, None, NO_RANGES, heard, proximity=ABOVE_ME, told=STOP)
    assert estimate is not None
    return estimate


def test_a_wall_corrects_once_all_neighbors_could_have_been_heard() -> None:
    early, late = (beside_the_wall(LpsConfig(), NOBODY, ticks) for ticks in (WALLS_AFTER, WALLS_AFTER + 1))

    assert early.position[1] == pytest.approx(-1.6)
    assert late.position[1] == pytest.approx(-2.0, abs=0.05)
    assert late.position[0] == early.position[0]


@pytest.mark.parametrize(
    "config", [LpsConfig(wall_sigma_m=None), LpsConfig(mode=LpsMode.LITERAL)], ids=["null", "literal"]
)
def test_walls_can_be_left_out_and_are_never_used_by_the_literal_mode(config: LpsConfig) -> None:
    assert beside_the_wall(config, NOBODY).position[1] == pytest.approx(-1.6)


def test_the_mission_computer_is_no_body_that_could_be_taken_for_a_wall() -> None:
    robot = make_presence(0.0, 0.4, 0.1)
    mission = replace(robot, robot_type=0)

    assert beside_the_wall(LpsConfig(), {NodeId(7): robot}).position[1] == pytest.approx(-1.6)
    assert beside_the_wall(LpsConfig(), {NodeId(0): mission}).position[1] == pytest.approx(-2.0, abs=0.05)


def test_who_fell_silent_is_still_a_body_where_it_was_last_heard() -> None:
    dead = {NodeId(7): make_presence(0.0, 0.4, 0.1)}

    assert beside_the_wall(LpsConfig(), dead, later=NOBODY).position[1] == pytest.approx(-1.6)


def test_walls_are_survived_by_a_robot_that_has_no_idea_where_it_is() -> None:
    localizer = Localizer(LpsConfig(), DT, None, (WALL,))

    assert all(
        localizer.step(tick, STILL, None, NO_RANGES, NOBODY, proximity=ABOVE_ME) is None
        for tick in range(2 * WALLS_AFTER)
    )


NEARLY_ON_A_LINE = np.array([[-5.0, 0.0], [0.0, 1.5], [5.0, 0.0]])
NORTH_OF_IT = np.array([1.0, 3.0])
RUNS, ROUNDS, TOLD_SIGMA = 40, 40, 3.0


def finds_the_truth(seed: int) -> bool:
    """Range to three beacons, from a start that was told 1.5 standard deviations off, on the other side of them."""
    rng = rng_for(seed, "mirror")
    start = NORTH_OF_IT - [0.0, 1.5 * TOLD_SIGMA]
    localizer = Localizer(LpsConfig(range_sigma_m=0.5), DT, PositionFix(start, TOLD_SIGMA))
    for tick in range(ROUNDS):
        heard = {NodeId(n): make_presence(x, y, 0.02, tick=tick) for n, (x, y) in enumerate(NEARLY_ON_A_LINE.tolist())}
        ranges = np.abs(np.linalg.norm(NEARLY_ON_A_LINE - NORTH_OF_IT, axis=1) + 0.5 * rng.normal(size=3))
        estimate = localizer.step(tick, STILL, None, RangeScan(np.arange(3), ranges), heard, told=STOP)
    assert estimate is not None
    return bool(np.hypot(*(estimate.position - NORTH_OF_IT)) < 1.0)


def test_several_hypotheses_find_the_right_side_of_beacons_where_one_settles_in_the_mirror_image(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    several = sum(finds_the_truth(seed) for seed in range(RUNS))
    monkeypatch.setattr(hypotheses, "WIDE_M", math.inf)
    single = sum(finds_the_truth(seed) for seed in range(RUNS))

    assert several >= 0.95 * RUNS  # 40 of 40
    assert single <= 0.8 * RUNS
