"""Records cross a link whole and in order, and nobody ever waits to send one."""

from __future__ import annotations

import numpy as np

from bringup.link import Link


def test_records_arrive_whole_and_in_order() -> None:
    here, there = Link.pair()

    for number in range(5):
        here.send((number, "x" * number))

    assert there.receive() == [(number, "x" * number) for number in range(5)]
    assert there.is_open


def test_more_than_the_socket_takes_is_kept_and_sent_later_without_waiting() -> None:
    here, there = Link.pair()
    blocks = [np.full(400_000, number, dtype=np.float64) for number in range(4)]

    for block in blocks:
        here.send(block)  # 3 MB each: far more than the socket buffers
    received = there.receive()
    assert len(received) < len(blocks)

    while not here.flush() or len(received) < len(blocks):
        received += there.receive()
    assert [block[0] for block in received] == [0.0, 1.0, 2.0, 3.0]


def test_what_was_sent_before_hanging_up_is_still_received() -> None:
    here, there = Link.pair()
    here.send("last words")
    here.close()

    assert there.receive() == ["last words"]
    assert not there.is_open


def test_sending_to_one_who_is_gone_is_in_vain_but_harmless() -> None:
    here, there = Link.pair()
    there.close()

    here.send("hello?")

    assert here.receive() == []
    assert not here.is_open


def test_waiting_tells_whether_there_is_something_to_receive() -> None:
    here, there = Link.pair()
    assert not there.wait(0.0)

    here.send(1)

    assert there.wait(1.0)
