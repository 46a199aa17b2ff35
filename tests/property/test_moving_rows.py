"""Rows of different times under goals that move: whatever the mixture, nobody is given another goal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.decision.assignment import assign
from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.offering import RowOffers
from swarm_agent.decision.path_costs import PathCosts
from swarm_agent.decision.rows import RowBook
from swarm_agent.energy import EnergyConfig, EnergyStore
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.messages.bodies import CostRow, Motion, Plan
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.plan_motion import goals_at
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import FloatArray, NodeId

PERIOD = 0.5
YARD = np.array([[-60.0, -60.0], [60.0, -60.0], [60.0, 60.0], [-60.0, 60.0]])
BEGINS, TICKS = 10, 40
STRANGER = NodeId(99)


class Offerer:
    """What offers the rows of one robot, and what it knows."""

    def __init__(self, robot: NodeId) -> None:
        mesh = MeshNetwork(robot, NetworkConfig(), PERIOD)
        mesh.receive(0, ())
        self.robot = robot
        self.consensus = Consensus(robot, 1, DecisionConfig(), PERIOD)
        self._offers = RowOffers(
            robot,
            config=DecisionConfig(),
            paths=PathCosts(THESIS_TYPES[0], PlanningConfig()),
            energy=EnergyStore(EnergyConfig(), PERIOD),
            mesh=mesh,
            consensus=self.consensus,
            period_s=PERIOD,
        )

    def row(self, tick: int, position: FloatArray, goal: int = -1, ticks: int = 1) -> CostRow:
        """Return the row that counts after some ticks at a place."""
        plan = self.consensus.plan
        assert plan is not None
        for later in range(ticks):
            self._offers.step(tick + later, plan, position, goal, takes_part=True)
        (own,) = (row for row in self.consensus.book.all_rows() if row.robot == self.robot)
        return own


def total(rows: list[CostRow], taken: dict[NodeId, int]) -> int:
    return sum(int(row.costs[taken[row.robot]]) for row in rows)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), size=st.integers(2, 6))
def test_fresh_rows_and_restarts_under_goals_that_have_moved_flip_nobody(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    before, after, starts = (rng.uniform(-20, 20, (size, 2)).round(2) for _ in range(3))
    types = np.ones(size, dtype=np.int64)
    first = Plan(1, YARD, (), before, types)
    motion = Motion(BEGINS, TICKS, YARD, 0.0, np.linspace(before, after, 8), 8)
    second = replace(first, epoch=2, goals=after, motion=motion, follows=1)
    robots = [Offerer(NodeId(number)) for number in range(size)]
    book = RowBook()
    book.adopt(first)
    for robot, start in zip(robots, starts, strict=True):
        robot.consensus.book.adopt(first)
        book.put(robot.row(0, start))
    taken = assign(book.offers)
    rows = {row.robot: row for row in book.all_rows()}
    tick = BEGINS + int(rng.integers(0, TICKS + 20))
    now = goals_at(second, tick)

    for robot, start in zip(robots, starts, strict=True):
        goal, fate = taken[robot.robot], rng.integers(0, 3)
        robot.consensus.book.adopt(second)
        if fate == 1:  # it is on its way when somebody joins
            robot.consensus.book.put(CostRow(2, STRANGER, 1, 1, np.full(size, 60_000)))
            far = (1.0 - rng.uniform(0, 1)) * (start - before[goal])
            rows[robot.robot] = robot.row(tick, now[goal] + far, goal, ticks=60 if tick >= BEGINS + TICKS else 1)
        elif fate == 2:  # it restarts at its goal
            again = Offerer(robot.robot)
            again.consensus.book.adopt(second)
            rows[robot.robot] = replace(again.row(tick, now[goal]), version=2)

    mixed = [replace(row, epoch=2) for row in rows.values()]
    flipped = assign(tuple(mixed))

    assert total(mixed, taken) - total(mixed, flipped) <= size + 1  # no more than rounding to centimeters can make
