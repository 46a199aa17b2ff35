"""Small valid objects for tests."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.step_io import AgentInputs
from swarm_msgs_py.types import FloatArray, NodeId

PERIOD = 0.5
SQUARE = np.array([[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]])


def make_agent(robot: int = 1, robot_type: int = 1) -> Agent:
    """Return an agent with all defaults."""
    return Agent(NodeId(robot), AgentConfig(), THESIS_TYPES[robot_type - 1], PERIOD)


def make_agent_inputs(tick: int = 0, **changes: Any) -> AgentInputs:
    """Return what a robot at rest in the origin, alone in the world, senses."""
    inputs = AgentInputs(
        tick=tick,
        time=tick * PERIOD,
        imu=ImuSample(np.zeros(2), 0.0, 0.0),
        fix=PositionFix(np.zeros(2), 0.02),
        ranges=RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0)),
        proximity=np.empty((0, 2)),
        inbox=(),
    )
    return replace(inputs, **changes)


def make_presence(x: float = 0.0, y: float = 0.0, sigma: float = 0.1, **changes: Any) -> Presence:
    """Return the presence of a beacon of type 1 at rest, without a plan."""
    presence = Presence(
        position=np.array([x, y]),
        velocity=np.zeros(2),
        covariance=np.diag([sigma**2, sigma**2]),
        shared=0.0,
        tick=0,
        robot_type=1,
        is_beacon=True,
        mode=0,
        epoch=0,
        digest=0,
    )
    return replace(presence, **changes)


def make_plan(goals: FloatArray, types: list[int] | None = None, epoch: int = 1) -> Plan:
    """Return a plan with these goals, all for type 1 unless told otherwise, in an 8 m square."""
    kinds = np.ones(len(goals), dtype=np.int64) if types is None else np.array(types, dtype=np.int64)
    return Plan(epoch, SQUARE, (), np.asarray(goals, dtype=float), kinds)
