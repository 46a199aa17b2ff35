"""Who takes which goal."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.decision.assignment import assign
from swarm_msgs_py.messages.bodies import UNREACHABLE, CostRow
from swarm_msgs_py.types import IntArray, NodeId


def rows_of(costs: IntArray) -> tuple[CostRow, ...]:
    return tuple(CostRow(1, NodeId(3 * i), 1, 1, np.asarray(row, dtype=np.int64)) for i, row in enumerate(costs))


def total(costs: IntArray, taken: dict[NodeId, int]) -> int:
    return sum(int(costs[robot // 3, goal]) for robot, goal in taken.items())


@st.composite
def cost_matrices(draw: st.DrawFn) -> IntArray:
    robots, goals = draw(st.integers(1, 5)), draw(st.integers(1, 5))
    cells = draw(st.lists(st.integers(0, 2000), min_size=robots * goals, max_size=robots * goals))
    return np.array(cells, dtype=np.int64).reshape(robots, goals)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(costs=cost_matrices())
def test_assignment_is_a_cheapest_matching(costs: IntArray) -> None:
    robots, goals = costs.shape
    size = min(robots, goals)
    cheapest = min(
        sum(int(costs[r, g]) for r, g in zip(chosen, order, strict=True))
        for chosen in itertools.combinations(range(robots), size)
        for order in itertools.permutations(range(goals), size)
    )

    taken = assign(rows_of(costs))

    assert len(taken) == len(set(taken.values())) == size
    assert total(costs, taken) == cheapest


@settings(max_examples=50, deadline=None, derandomize=True)
@given(costs=cost_matrices(), order=st.randoms(use_true_random=False))
def test_everybody_finds_the_same_assignment_whatever_the_order_of_arrival(costs: IntArray, order: object) -> None:
    rows = list(rows_of(costs))
    shuffled = rows.copy()
    order.shuffle(shuffled)  # type: ignore[attr-defined]

    assert assign(tuple(shuffled)) == assign(tuple(rows))


def test_a_goal_without_a_path_is_taken_by_nobody() -> None:
    costs = np.array([[10, UNREACHABLE], [20, UNREACHABLE]])

    assert assign(rows_of(costs)) == {NodeId(0): 0}


def test_a_detour_is_better_than_leaving_a_robot_without_goal() -> None:
    costs = np.array([[10, 500], [20, UNREACHABLE]])

    assert assign(rows_of(costs)) == {NodeId(0): 1, NodeId(3): 0}


def test_no_rows_give_no_assignment() -> None:
    assert assign(()) == {}
