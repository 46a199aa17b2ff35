"""Headings without a compass: what was told to the wheels, put right by who sees the robot."""

from __future__ import annotations

import math

import numpy as np
import pytest

from swarm_agent.localization.camera_fixes import SeenFrom
from swarm_agent.localization.config import LpsConfig
from swarm_agent.localization.heading import Heading
from swarm_msgs_py.messages.sensing import PoseFix
from swarm_msgs_py.types import NodeId

DT = 0.1


def seen(tick: int, yaw: float, sigma: float = 0.002) -> SeenFrom:
    return SeenFrom(tick, PoseFix(NodeId(0), np.zeros(2), yaw, 0.001, sigma))


def heading() -> Heading:
    return Heading(LpsConfig(from_camera=True), DT)


def test_nobody_knows_a_heading_that_nobody_has_told() -> None:
    assert heading().step(0, None, 0.3, None) is None


def test_a_compass_is_believed_whatever_else_is_said() -> None:
    assert heading().step(0, 0.7, 0.0, seen(0, 2.0)) == 0.7


def test_between_fixes_the_robot_reckons_with_what_it_told_its_wheels() -> None:
    one = heading()
    one.step(0, None, 0.0, seen(0, 3.0))
    for tick in range(1, 6):
        one.step(tick, None, 0.5, None)

    assert one.yaw == pytest.approx(math.remainder(3.0 + 0.25, math.tau))
    assert one.sigma > 0.002


def test_a_late_fix_counts_for_where_the_robot_has_turned_since() -> None:
    one = heading()
    one.step(0, None, 0.0, seen(0, 0.0))
    for tick in range(1, 4):
        one.step(tick, None, 1.0, None)
    found = one.step(4, None, 1.0, seen(2, 0.2))  # after two of four ticks

    assert found == pytest.approx(0.4, abs=1e-6)


def test_fixes_are_taken_the_short_way_around() -> None:
    one = heading()
    one.step(0, None, 0.0, seen(0, 3.13))
    found = one.step(1, None, 0.0, seen(1, -3.13))

    assert found is not None
    assert abs(found) > 3.13 - 1e-9


def test_one_wild_fix_is_ignored_and_many_are_believed() -> None:
    one = heading()
    one.step(0, None, 0.0, seen(0, 0.0))

    assert abs(one.step(1, None, 0.0, seen(1, 2.0)) or 0.0) < 0.01
    for tick in range(2, 8):
        one.step(tick, None, 0.0, seen(tick, 2.0))
    assert one.yaw == pytest.approx(2.0, abs=0.01)


def test_slipping_wheels_are_corrected() -> None:
    one, true = heading(), 0.0
    rng = np.random.default_rng(5)
    one.step(0, None, 0.0, seen(0, 0.0))
    for tick in range(1, 200):
        before, true = true, true + 0.4 * DT * 0.9
        one.step(tick, None, 0.4, seen(tick - 1, before + rng.normal(0.0, 0.002)))

    assert one.yaw is not None
    assert abs(math.remainder(one.yaw - true, math.tau)) < math.radians(1.0)
