"""Every transition of the table in spec section 6, on scripted signs."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import pytest

from swarm_agent.localization.config import LostConfig, LostRule, LpsConfig, LpsMode
from swarm_agent.localization.positioning import PositioningMonitor, Signs
from swarm_msgs_py.messages.report import Positioning

DT = 0.5
EVERY = 6  # ticks from review to review: 3 s
GOOD = Signs(beacons=3, has_fix=False, accepted=True, sigma=0.3)
BAD = Signs(beacons=2, has_fix=False, accepted=True, sigma=3.0)
LOCALIZED, LOST, RETURN_HOME = Positioning


class Robot:
    """Steps a monitor from one review to the next."""

    def __init__(self, rule: LostRule = LostRule.BEACONS, lps: LpsConfig | None = None, **lost: int | float) -> None:
        config = lps or LpsConfig()
        self.monitor = PositioningMonitor(replace(config, lost=LostConfig(rule=rule, **lost)), DT)  # type: ignore[arg-type]
        self.tick = 0
        self.monitor.step(0, replace(GOOD, accepted=False))

    def review(self, signs: Signs) -> Positioning:
        before = self.monitor.state
        for _ in range(EVERY - 1):
            self.tick += 1
            assert self.monitor.step(self.tick, signs) is before  # nothing changes between two reviews
        self.tick += 1
        return self.monitor.step(self.tick, signs)

    def reviews(self, script: str) -> list[Positioning]:
        return [self.review(GOOD if sign == "+" else BAD) for sign in script]


@pytest.mark.parametrize("rule", LostRule)
@pytest.mark.parametrize(
    ("script", "states"),
    [
        ("+++", [LOCALIZED] * 3),
        ("-", [LOST]),
        ("-+", [LOST, LOCALIZED]),
        ("--+", [LOST, LOST, LOCALIZED]),
        ("---", [LOST, LOST, RETURN_HOME]),
        ("--+--+", [LOST, LOST, LOCALIZED] * 2),  # one good review sets the counter back
        ("----", [LOST, LOST, RETURN_HOME, RETURN_HOME]),
        ("---+", [LOST, LOST, RETURN_HOME, RETURN_HOME]),
        ("---++", [LOST, LOST, RETURN_HOME, RETURN_HOME, LOCALIZED]),
        ("---+-++", [LOST, LOST, *[RETURN_HOME] * 4, LOCALIZED]),  # in a row
        ("---++-", [LOST, LOST, RETURN_HOME, RETURN_HOME, LOCALIZED, LOST]),
        ("---++---", [LOST, LOST, RETURN_HOME, RETURN_HOME, LOCALIZED, LOST, LOST, RETURN_HOME]),
    ],
)
def test_states_follow_the_table(rule: LostRule, script: str, states: list[Positioning]) -> None:
    assert Robot(rule).reviews(script) == states


def test_all_scripts_of_seven_reviews_follow_an_independent_reading_of_the_table() -> None:
    for script in product("+-", repeat=7):
        history, state = "", LOCALIZED
        robot = Robot()
        for sign in script:
            history += sign
            if state is RETURN_HOME:
                state = LOCALIZED if history.endswith("++") else RETURN_HOME
            elif sign == "+":
                state = LOCALIZED
            else:
                state = RETURN_HOME if history.endswith("---") else LOST
            assert robot.reviews(sign) == [state]


def test_a_robot_returns_home_nine_seconds_after_it_was_localized_last() -> None:
    robot = Robot()
    robot.reviews("+")

    ticks = 0
    while robot.monitor.state is not RETURN_HOME:
        ticks += 1
        robot.monitor.step(robot.tick + ticks, BAD)

    assert ticks * DT == 9.0


@pytest.mark.parametrize(("misses", "returns"), [(1, 1), (2, 3), (5, 1)])
def test_the_numbers_of_reviews_are_settings(misses: int, returns: int) -> None:
    robot = Robot(misses_max=misses, returns_min=returns)

    assert robot.reviews("-" * misses) == [LOST] * (misses - 1) + [RETURN_HOME]
    assert robot.reviews("+" * returns) == [RETURN_HOME] * (returns - 1) + [LOCALIZED]


@pytest.mark.parametrize(
    ("signs", "by_beacons", "by_sigma"),
    [
        (Signs(3, False, True, 1.0), False, False),
        (Signs(3, False, True, 1.01), False, True),
        (Signs(2, False, True, 0.1), True, False),
        (Signs(3, False, False, 0.1), True, False),  # beacons in reach, but no fix was accepted
        (Signs(0, False, False, math.inf), True, True),
        (Signs(8, False, True, math.nan), False, True),  # nobody knows what that is: lost
        (Signs(0, True, True, 0.02), False, False),
        (Signs(0, True, False, 5.0), False, False),  # a beacon is never lost
    ],
)
@pytest.mark.parametrize("rule", LostRule)
def test_both_definitions_are_reported_and_one_acts(
    signs: Signs, by_beacons: bool, by_sigma: bool, rule: LostRule
) -> None:
    robot = Robot(rule)

    state = robot.review(signs)

    assert (robot.monitor.lost_by_beacons, robot.monitor.lost_by_sigma) == (by_beacons, by_sigma)
    assert state is (LOST if (by_beacons if rule is LostRule.BEACONS else by_sigma) else LOCALIZED)


def test_one_accepted_fix_between_two_reviews_is_enough_and_counts_for_one_review_only() -> None:
    robot = Robot()
    nothing = replace(GOOD, accepted=False)
    for tick in range(1, 2 * EVERY + 1):
        state = robot.monitor.step(tick, GOOD if tick == 2 else nothing)
        assert state is (LOST if tick == 2 * EVERY else LOCALIZED)


def test_beacons_count_at_the_moment_of_the_review() -> None:
    robot = Robot()
    for tick in range(1, EVERY):
        robot.monitor.step(tick, GOOD)

    assert robot.monitor.step(EVERY, BAD) is LOST


def test_a_beacon_is_never_lost_as_long_as_its_sensor_works() -> None:
    beacon = Signs(beacons=0, has_fix=True, accepted=False, sigma=9.0)
    for rule in LostRule:
        robot = Robot(rule)
        assert [robot.review(beacon) for _ in range(10)] == [LOCALIZED] * 10
        assert robot.review(BAD) is LOST  # the sensor has died


def test_a_slow_localization_timer_is_not_taken_for_missed_localizations() -> None:
    robot = Robot(lps=LpsConfig(mode=LpsMode.FIXES, period_s=8.0))
    states = set()
    for tick in range(1, 40 * 16):
        states.add(robot.monitor.step(tick, replace(GOOD, accepted=tick % 16 == 0)))

    assert states == {LOCALIZED}


@pytest.mark.parametrize(
    ("mode", "rule"),
    [
        (LpsMode.COOPERATIVE, LostRule.SIGMA),
        (LpsMode.RANGE_EKF, LostRule.BEACONS),
        (LpsMode.FIXES, LostRule.BEACONS),
        (LpsMode.LITERAL, LostRule.BEACONS),
    ],
)
def test_the_rule_follows_the_mode_unless_it_is_set(mode: LpsMode, rule: LostRule) -> None:
    assert LpsConfig(mode=mode).lost_rule is rule
    for wanted in LostRule:
        assert LpsConfig(mode=mode, lost=LostConfig(rule=wanted)).lost_rule is wanted


def test_transitions_are_logged_with_their_reason(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level("INFO"):
        Robot().reviews("---+++")

    assert [record.getMessage().split(" (")[0] for record in caplog.records] == [
        "positioning: LOCALIZED to LOST",
        "positioning: LOST to RETURN_HOME",
        "positioning: RETURN_HOME to LOCALIZED",
    ]
    assert "2 beacons, sigma 3.00 m" in caplog.records[0].getMessage()
