"""The replicated set of cost rows: order of arrival, repetition and loss must not matter in the end."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_agent.decision.rows import RowBook
from swarm_msgs_py.messages.bodies import CostRow, Plan
from swarm_msgs_py.types import NodeId

GOALS = 2


def make_plan(epoch: int = 1) -> Plan:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    return Plan(epoch, square, (), np.array([[1.0, 1.0], [3.0, 3.0]]), np.array([1, 1]))


def make_row(robot: int, version: int, epoch: int = 1, length: int = GOALS) -> CostRow:
    return CostRow(epoch, NodeId(robot), 1, version, np.full(length, 100 * robot + version))


def make_book(*rows: CostRow) -> RowBook:
    book = RowBook()
    book.adopt(make_plan())
    for row in rows:
        book.put(row)
    return book


row_lists = st.lists(st.builds(make_row, robot=st.integers(0, 5), version=st.integers(1, 4)), max_size=12)


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
