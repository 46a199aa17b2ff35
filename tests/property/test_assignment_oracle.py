"""The assignment against trying all: least total, least longest path, fewest robots without a goal, ties by number."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles_assignment import best_total, every_assignment, least_longest, lengths, longest

from swarm_agent.decision.assignment import assign
from swarm_msgs_py.messages.bodies import UNREACHABLE, WEIGHT_ONE, CostRow, Objective
from swarm_msgs_py.types import NodeId

BOTTLENECK = Objective.BOTTLENECK


@st.composite
def rows_of_one_type(draw: st.DrawFn, most: int = 6, kind: int = 1) -> tuple[CostRow, ...]:
    """Return rows of unequal weights, few different costs (so that many are tied), some goals without a path."""
    robots, goals = draw(st.integers(1, most)), draw(st.integers(1, most))
    dearest = draw(st.sampled_from([3, 40, 60000]))
    cost = st.integers(0, dearest)
    cell = st.one_of(cost, cost, cost, st.just(UNREACHABLE))
    weight = st.sampled_from([WEIGHT_ONE // 2, WEIGHT_ONE, WEIGHT_ONE, 3 * WEIGHT_ONE])
    return tuple(
        CostRow(
            1, NodeId(10 * kind + 3 * n), kind, 1, np.array(draw(st.lists(cell, min_size=goals, max_size=goals))),
            weight=draw(weight),
        )
        for n in range(robots)
    )  # fmt: skip


def wanting_bottleneck(rows: tuple[CostRow, ...]) -> tuple[CostRow, ...]:
    return tuple(replace(row, objective=BOTTLENECK) for row in rows)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(rows=rows_of_one_type())
def test_the_total_is_the_least_there_is_for_as_many_robots_as_can_have_a_goal(rows: tuple[CostRow, ...]) -> None:
    expected, taken = best_total(rows), assign(rows)

    assert len(taken) == len(set(taken.values())) == len(expected)
    assert sum(lengths(rows, taken)) == sum(lengths(rows, expected))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(rows=rows_of_one_type())
def test_the_longest_path_is_the_least_there_is_and_the_total_the_least_with_it(rows: tuple[CostRow, ...]) -> None:
    limit = least_longest(rows)
    expected, taken = best_total(rows, limit), assign(wanting_bottleneck(rows))

    assert longest(rows, taken) == limit
    assert len(taken) == len(set(taken.values())) == len(expected)
    assert sum(lengths(rows, taken)) == sum(lengths(rows, expected))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(rows=rows_of_one_type(most=5))
def test_of_equally_good_assignments_the_lowest_robot_has_the_lowest_goal(rows: tuple[CostRow, ...]) -> None:
    assert assign(rows) == best_total(rows)
    assert assign(wanting_bottleneck(rows)) == best_total(rows, least_longest(rows))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(small=rows_of_one_type(most=3), middle=rows_of_one_type(most=3, kind=2), large=rows_of_one_type(most=2, kind=3))
def test_the_types_together_are_as_good_as_if_they_were_one_problem(
    small: tuple[CostRow, ...], middle: tuple[CostRow, ...], large: tuple[CostRow, ...]
) -> None:
    rows = small + middle + large
    groups = (small, middle, large)
    # Every combination of one assignment per type: this oracle knows nothing of thresholds.
    best = min(
        (
            -sum(map(len, parts)),
            max(longest(group, taken) for group, taken in zip(groups, parts, strict=True)),
            sum(sum(lengths(group, taken)) for group, taken in zip(groups, parts, strict=True)),
        )
        for parts in itertools.product(*(list(every_assignment(group)) for group in groups))
    )

    taken = assign(wanting_bottleneck(rows))

    assert (-len(taken), longest(rows, taken), sum(lengths(rows, taken))) == best


@settings(max_examples=60, deadline=None, derandomize=True)
@given(rows=rows_of_one_type(), robot=st.integers(0, 5), factor=st.integers(2, 9))
def test_who_counts_more_never_drives_farther_for_it(rows: tuple[CostRow, ...], robot: int, factor: int) -> None:
    index = robot % len(rows)
    heavier = replace(rows[index], weight=factor * rows[index].weight)
    before, after = assign(rows), assign((*rows[:index], heavier, *rows[index + 1 :]))

    def driven(taken: dict[NodeId, int]) -> int:
        return sum(lengths([rows[index]], taken))

    assert driven(after) <= driven(before)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(rows=rows_of_one_type(), other=rows_of_one_type(kind=2), random=st.randoms(use_true_random=False))
def test_robots_of_different_settings_agree_whatever_the_order_of_arrival(
    rows: tuple[CostRow, ...], other: tuple[CostRow, ...], random: object
) -> None:
    mixed = [replace(row, objective=random.choice(list(Objective))) for row in rows + other]  # type: ignore[attr-defined]
    shuffled = list(mixed)
    random.shuffle(shuffled)  # type: ignore[attr-defined]

    taken = assign(shuffled)

    assert taken == assign(mixed)
    for group in (rows, other):
        goals = [taken[row.robot] for row in group if row.robot in taken]
        assert len(set(goals)) == len(goals)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), size=st.integers(2, 7))
def test_fresh_rows_of_whole_paths_move_nobody_in_any_mixture(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    starts, goals = rng.uniform(-40, 40, (size, 2)), rng.uniform(-10, 10, (size, 2))
    weights = rng.integers(100, 600, size)
    ways = np.rint(np.linalg.norm(starts[:, None] - goals, axis=2) * 100).astype(int)
    old = [CostRow(1, NodeId(n), 1, 1, ways[n], int(weights[n]), BOTTLENECK) for n in range(size)]
    before = assign(old)
    own = [before[NodeId(n)] for n in range(size)]
    driven = starts + rng.uniform(0, 1, (size, 1)) * (goals[own] - starts)
    left = np.rint(np.linalg.norm(driven[:, None] - goals, axis=2) * 100).astype(int)
    spent = ways[np.arange(size), own] - left[np.arange(size), own]
    fresh = left + spent[:, None] + 50  # the margin that a row adds to all goals but the own
    fresh[np.arange(size), own] -= 50
    mixed = [replace(row, version=2, costs=fresh[row.robot]) if rng.random() < 0.5 else row for row in old]

    assert assign(mixed) == before
