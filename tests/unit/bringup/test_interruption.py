from __future__ import annotations

import os
import signal

import pytest

from bringup.interruption import Interruption


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_block_that_welcomes_it(number: signal.Signals) -> None:
    with Interruption() as interruption, pytest.raises(KeyboardInterrupt), interruption.welcome():
        os.kill(os.getpid(), number)

    assert interruption.requested


def test_elsewhere_a_signal_is_noted_and_ends_the_next_block() -> None:
    reached = []
    with Interruption() as interruption:
        os.kill(os.getpid(), signal.SIGINT)
        reached.append("after")
        with pytest.raises(KeyboardInterrupt), interruption.welcome():
            reached.append("never")

    assert reached == ["after"]


def test_only_the_first_signal_raises() -> None:
    with Interruption() as interruption:
        with pytest.raises(KeyboardInterrupt), interruption.welcome():
            os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGTERM)

    assert interruption.requested


def test_the_signals_are_given_back() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with Interruption():
        assert signal.getsignal(signal.SIGINT) != before[0]

    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_a_hangup_that_is_ignored_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Interruption() as interruption, interruption.welcome():
            os.kill(os.getpid(), signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)

    assert not interruption.requested
