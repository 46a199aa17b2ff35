"""The replicated set of cost rows: order of arrival, repetition and loss must not matter in the end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.decision.assignment import assign
from swarm_agent.decision.rows import EARLY_MAX, RowBook
from swarm_msgs_py.messages.bodies import UNREACHABLE, WEIGHT_ONE, CostRow, Plan
from swarm_msgs_py.types import NodeId

GOALS = 2


def make_plan(epoch: int = 1) -> Plan:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    return Plan(epoch, square, (), np.array([[1.0, 1.0], [3.0, 3.0]]), np.array([1, 1]))


def make_row(robot: int, version: int, epoch: int = 1, length: int = GOALS, life: int = 0) -> CostRow:
    return CostRow(epoch, NodeId(robot), 1, version, np.full(length, 20 * robot + version + 20_000 * life))


def make_book(*rows: CostRow) -> RowBook:
    book = RowBook()
    book.adopt(make_plan())
    for row in rows:
        book.put(row)
    return book


row_lists = st.lists(st.builds(make_row, robot=st.integers(0, 5), version=st.integers(1, 4)), max_size=12)
lives = st.builds(make_row, robot=st.integers(0, 3), version=st.integers(1, 3), life=st.integers(0, 1))


@settings(max_examples=100, deadline=None, derandomize=True)
@given(rows=st.lists(lives, max_size=12), random=st.randoms(use_true_random=False))
def test_of_two_rows_under_one_number_all_keep_the_same(rows: list[CostRow], random: object) -> None:
    shuffled = list(rows)
    random.shuffle(shuffled)  # type: ignore[attr-defined]

    one, other = make_book(*rows), make_book(*shuffled)

    assert [row.costs.tolist() for row in one.all_rows()] == [row.costs.tolist() for row in other.all_rows()]
    assert one.digest == other.digest


def test_books_whose_rows_say_something_else_under_the_same_numbers_have_other_digests() -> None:
    rows = [make_row(0, 1), make_row(0, 1, life=1), replace(make_row(0, 1), weight=WEIGHT_ONE + 1)]

    assert len({make_book(row).digest for row in rows}) == 3


@settings(max_examples=100, deadline=None, derandomize=True)
@given(rows=row_lists, random=st.randoms(use_true_random=False))
def test_books_that_got_the_same_rows_are_equal(rows: list[CostRow], random: object) -> None:
    shuffled = rows + rows[: len(rows) // 2]
    random.shuffle(shuffled)  # type: ignore[attr-defined]

    one, other = make_book(*rows), make_book(*shuffled)

    assert one.digest == other.digest
    assert one.versions() == other.versions()


@settings(max_examples=100, deadline=None, derandomize=True)
@given(mine=row_lists, theirs=row_lists)
def test_after_an_exchange_of_what_is_missing_both_hold_the_same(mine: list[CostRow], theirs: list[CostRow]) -> None:
    one, other = make_book(*mine), make_book(*theirs)
    to_other, to_one = one.missing_in(other.versions()), other.missing_in(one.versions())

    for row in to_other:
        other.put(row)
    for row in to_one:
        one.put(row)

    assert one.versions() == other.versions()
    assert one.digest == other.digest


def test_a_newer_plan_forgets_the_rows_of_the_old() -> None:
    book = make_book(make_row(0, 1))

    assert book.adopt(make_plan(epoch=2))
    assert len(book) == 0
    assert book.digest == 0
    assert not book.put(make_row(0, 5, epoch=1))


def test_an_older_plan_is_refused() -> None:
    book = make_book()

    assert not book.adopt(make_plan(epoch=1))


def test_a_row_that_does_not_fit_the_plan_is_refused() -> None:
    book = make_book()

    assert not book.put(make_row(0, 1, length=GOALS + 1))
    assert book.of_type(1) == ()


def test_a_withdrawn_row_takes_its_robot_out_of_the_assignment() -> None:
    book = make_book(make_row(0, 1), make_row(1, 1))

    book.put(make_row(0, 2, length=0))

    assert [row.robot for row in book.of_type(1)] == [1]


def test_a_withdrawn_robot_has_answered() -> None:
    book = make_book(make_row(0, 1), make_row(1, 1, length=0))

    assert book.answered(1) == 2
    assert book.answered(2) == 0


def test_the_book_is_complete_when_as_many_robots_have_answered_as_there_are_goals() -> None:
    book = make_book(make_row(0, 1))
    before = book.is_complete([1])
    book.put(make_row(1, 1, length=0))

    assert [before, book.is_complete([1]), book.is_complete([1, 2])] == [False, True, True]
    assert not RowBook().is_complete([1])


def test_the_weight_of_a_robot_is_what_its_newest_row_says() -> None:
    book = make_book(make_row(0, 1), replace(make_row(0, 2), weight=700))

    assert [book.weight_of(NodeId(0)), book.weight_of(NodeId(1))] == [700, WEIGHT_ONE]


@st.composite
def sets_of_rows(draw: st.DrawFn) -> tuple[int, list[CostRow]]:
    """Return a number of goals and rows for them: costs, reservations of one goal, and withdrawn robots."""
    goals = draw(st.integers(1, 6))
    cost = st.one_of(st.integers(0, 9000), st.just(UNREACHABLE))
    rows = []
    for robot in range(draw(st.integers(0, 8))):
        reserved = draw(st.integers(0, goals - 1))
        kinds = [
            np.array(draw(st.lists(cost, min_size=goals, max_size=goals))),
            np.where(np.arange(goals) == reserved, 0, UNREACHABLE),
            np.empty(0, dtype=np.int64),
        ]
        rows.append(CostRow(1, NodeId(robot), 1, 1, kinds[draw(st.integers(0, 2))]))
    return goals, rows


def book_with(goals: int, rows: list[CostRow]) -> RowBook:
    book = RowBook()
    book.adopt(replace(make_plan(), goals=np.zeros((goals, 2)), goal_types=np.ones(goals, dtype=np.int64)))
    for row in rows:
        book.put(row)
    return book


@settings(max_examples=150, deadline=None, derandomize=True)
@given(drawn=sets_of_rows(), random=st.randoms(use_true_random=False))
def test_whatever_the_rows_and_their_order_no_goal_is_given_twice_or_without_a_path(
    drawn: tuple[int, list[CostRow]], random: object
) -> None:
    goals, rows = drawn
    shuffled = list(rows)
    random.shuffle(shuffled)  # type: ignore[attr-defined]

    taken = assign(book_with(goals, rows).of_type(1))

    assert taken == assign(book_with(goals, shuffled).of_type(1))
    assert len(set(taken.values())) == len(taken)
    costs = {row.robot: row.costs for row in rows}
    assert all(costs[robot][goal] != UNREACHABLE for robot, goal in taken.items())


@settings(max_examples=150, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), size=st.integers(1, 7), away=st.sets(st.integers(0, 6), max_size=4))
def test_robots_that_withdraw_and_keep_their_goals_change_nobody_elses_costs(
    seed: int, size: int, away: set[int]
) -> None:
    costs = np.random.default_rng(seed).integers(0, 9000, (size, size))
    rows = [CostRow(1, NodeId(robot), 1, 1, costs[robot]) for robot in range(size)]
    before = assign(book_with(size, rows).of_type(1))
    left = [
        replace(row, version=2, costs=np.where(np.arange(size) == before[row.robot], 0, UNREACHABLE))
        if row.robot in away
        else row
        for row in rows
    ]

    after = assign(book_with(size, left).of_type(1))

    assert {robot: after[robot] for robot in after if robot in away} == {
        robot: before[robot] for robot in before if robot in away
    }
    stayed = [robot for robot in before if robot not in away]
    assert sum(costs[robot, after[robot]] for robot in stayed) == sum(costs[robot, before[robot]] for robot in stayed)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), size=st.integers(2, 7))
def test_fresh_rows_of_robots_on_their_way_move_nobody_in_any_mixture(seed: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    starts, goals = rng.uniform(-40, 40, (size, 2)), rng.uniform(-10, 10, (size, 2))
    distances = np.linalg.norm(starts[:, None] - goals, axis=2)
    old = [CostRow(1, NodeId(robot), 1, 1, np.rint(distances[robot] * 100)) for robot in range(size)]
    before = assign(book_with(size, old).of_type(1))
    driven = starts + rng.uniform(0, 1, (size, 1)) * (goals[[before[NodeId(robot)] for robot in range(size)]] - starts)
    fresh = np.linalg.norm(driven[:, None] - goals, axis=2) * 100
    fresh[np.arange(size), [before[NodeId(robot)] for robot in range(size)]] -= 50  # what a row says for the own goal
    mixed = [
        replace(row, version=2, costs=np.rint(np.maximum(fresh[row.robot], 0))) if rng.random() < 0.5 else row
        for row in old
    ]

    after = assign(book_with(size, mixed).of_type(1))

    def total(taken: dict[NodeId, int]) -> float:
        return sum(float(mixed[robot].costs[goal]) for robot, goal in taken.items())

    assert total(before) - total(after) <= size + 1  # no more than rounding to whole centimeters can make


@settings(max_examples=60, deadline=None, derandomize=True)
@given(early=row_lists, late=row_lists)
def test_rows_that_come_before_their_plan_count_as_if_they_had_come_after_it(
    early: list[CostRow], late: list[CostRow]
) -> None:
    book = RowBook()
    for row in early:
        assert not book.put(row)
    book.adopt(make_plan())
    for row in late:
        book.put(row)

    assert book.digest == make_book(*early, *late).digest
    assert book.versions() == make_book(*early, *late).versions()


def test_early_rows_of_a_plan_that_is_passed_over_are_forgotten() -> None:
    book = make_book()
    book.put(make_row(1, 1, epoch=2))
    book.put(make_row(2, 1, epoch=3))

    book.adopt(make_plan(3))

    assert book.versions() == ((2, 1),)


def test_rows_of_an_old_plan_are_not_kept() -> None:
    book = RowBook()
    book.adopt(make_plan(3))

    assert not book.put(make_row(1, 1, epoch=2))
    assert len(book) == 0


def test_a_flood_of_rows_without_a_plan_fills_no_memory() -> None:
    book = RowBook()
    for robot in range(2 * EARLY_MAX):
        book.put(make_row(robot, 1, epoch=2))

    book.adopt(make_plan(2))

    assert len(book) == EARLY_MAX
