"""Who is waited for in a tick, and what becomes of answers that come late."""

from __future__ import annotations

import pytest

from swarm_msgs_py.messages.control import STOP, VelocityCommand
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.answers import AnswerBook

FIRST, SECOND = NodeId(0), NodeId(1)


@pytest.fixture
def book() -> AnswerBook:
    return AnswerBook((FIRST, SECOND, MISSION))


def answer(book: AnswerBook, tick: int, *nodes: NodeId) -> None:
    for node in nodes:
        if node != MISSION:
            book.put_command(node, tick, STOP)
        book.put_frames(node, tick, (b"%d" % tick,))


def test_a_tick_is_complete_with_command_and_frames_of_every_robot_and_the_frames_of_the_mission_computer(
    book: AnswerBook,
) -> None:
    book.open(0)
    answer(book, 0, FIRST, MISSION)
    book.put_frames(SECOND, 0, ())
    assert book.missing == (SECOND,)

    book.put_command(SECOND, 0, VelocityCommand(1.0, 2.0))

    assert book.is_complete
    answers = book.close()
    assert answers.complete == {FIRST, SECOND, MISSION}
    assert answers.commands == {FIRST: STOP, SECOND: VelocityCommand(1.0, 2.0)}
    assert answers.outboxes == {FIRST: (b"0",), SECOND: (), MISSION: (b"0",)}
    assert (answers.silenced, answers.recovered) == ((), ())


def test_who_lets_a_tick_pass_is_not_waited_for_in_the_next(book: AnswerBook) -> None:
    book.open(0)
    answer(book, 0, FIRST, MISSION)
    assert book.close().silenced == (SECOND,)

    book.open(1)
    answer(book, 1, FIRST, MISSION)

    assert book.is_complete
    assert book.close().silenced == ()


def test_a_late_command_is_dropped_and_late_frames_go_out_before_the_new_ones(book: AnswerBook) -> None:
    book.open(0)
    answer(book, 0, FIRST, MISSION)
    book.close()

    book.open(1)
    answer(book, 0, SECOND)
    answers_missing = book.missing
    answer(book, 1, FIRST, MISSION)
    first = book.close()
    book.open(2)
    book.put_frames(SECOND, 1, (b"late",))
    answer(book, 2, FIRST, SECOND, MISSION)
    second = book.close()

    assert answers_missing == (FIRST, MISSION)
    assert SECOND not in first.commands
    assert first.outboxes[SECOND] == (b"0",)
    assert first.recovered == (SECOND,)
    assert second.outboxes[SECOND] == (b"late", b"2")
    assert second.complete == {FIRST, SECOND, MISSION}


def test_frames_that_come_between_two_ticks_are_late_and_not_lost(book: AnswerBook) -> None:
    book.open(7)
    book.close()
    book.put_frames(MISSION, 7, (b"late",))

    book.open(8)
    book.put_frames(MISSION, 8, (b"in time",))

    assert book.close().outboxes == {MISSION: (b"late", b"in time")}


def test_who_is_heard_again_is_waited_for_again(book: AnswerBook) -> None:
    book.open(0)
    answer(book, 0, FIRST, MISSION)
    book.close()
    book.open(1)
    answer(book, 0, SECOND)
    answer(book, 1, FIRST, MISSION)
    book.close()

    book.open(2)

    assert SECOND in book.missing


def test_a_swarm_is_deserted_while_no_robot_that_lives_is_heard(book: AnswerBook) -> None:
    book.open(0)
    answer(book, 0, MISSION)
    before = book.is_deserted
    book.close()
    book.open(1)
    answer(book, 1, MISSION)  # answers at once, and would let the world race on
    after = book.is_deserted
    answer(book, 0, SECOND)

    assert (before, after, book.is_deserted) == (False, True, False)
    book.close()
    book.open(2)
    assert book.missing == (SECOND, MISSION)


def test_without_robots_the_silence_of_the_mission_computer_counts_and_without_anybody_none_does(
    book: AnswerBook,
) -> None:
    book.remove(FIRST)
    book.remove(SECOND)
    book.open(0)
    book.close()
    book.open(1)
    alone = book.is_deserted
    book.remove(MISSION)

    assert (alone, book.is_deserted) == (True, False)


def test_nothing_is_expected_or_taken_from_the_dead(book: AnswerBook) -> None:
    book.open(0)
    answer(book, 0, FIRST, MISSION)
    book.remove(SECOND)
    answer(book, 0, SECOND)

    answers = book.close()

    assert answers.complete == {FIRST, MISSION}
    assert SECOND not in answers.commands
    assert SECOND not in answers.outboxes
    book.open(1)
    assert book.missing == (FIRST, MISSION)


def test_frames_of_a_tick_that_has_not_begun_are_not_taken(book: AnswerBook) -> None:
    book.open(0)
    book.put_frames(FIRST, 7, (b"from the future",))

    assert FIRST not in book.close().outboxes
