"""By whom a robot keeps its place: the nearest linked robot toward the leader, all sensed ones where robots drift."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from swarm_agent.coverage.config import CoverageConfig, MotionConfig
from swarm_agent.coverage.frames import Place, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_agent.coverage.whereabouts import Scale, farthest_off, upstream
from swarm_msgs_py.coverage_io import CoverageInputs
from swarm_msgs_py.types import NodeId

KEYS = [(NodeId(0), number) for number in range(4)]
PLACES = [(0.0, 0.0, 0.0), (40.0, 0.0, 0.0), (80.0, 0.0, 0.0), (120.0, 0.0, 0.0)]
HELD = {NodeId(n): Place(KEYS[n], 0, State.HELD, NodeId(n), PLACES[n]) for n in range(4)}
HOPS = {key: number for number, key in enumerate(KEYS)}
AROUND = Surroundings(  # of robot 2, which has drifted 15 m away from robot 1
    CoverageInputs(0, 0.0, np.array([0, 1, 3]), np.array([[-95.0, 0, 0], [-55.0, 0, 0], [25.0, 0, 0]]), None, ())
)
DRIFTING = replace(CoverageConfig(), motion=replace(MotionConfig(), drifts=True))


@pytest.mark.parametrize(("config", "found"), [(CoverageConfig(), []), (DRIFTING, [1, 0])])
def test_a_robot_whose_link_broke_finds_back_where_robots_drift(config: CoverageConfig, found: list[int]) -> None:
    assert [robot for robot, _ in upstream(AROUND, HELD, HOPS, KEYS[2], config)] == found


def test_the_farthest_claim_tells_whether_a_search_is_worth_while() -> None:
    target = np.array(PLACES[2])

    assert farthest_off(target, AROUND, HELD, Scale(np.zeros(3), 1.0)) == pytest.approx(15.0)
    assert farthest_off(target, AROUND, {}, Scale(np.zeros(3), 1.0)) == 0.0
