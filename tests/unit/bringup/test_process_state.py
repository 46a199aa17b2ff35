"""Who computes is told from who sleeps, is stopped or is dead."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from leftovers import wait_until

from bringup.process_state import computing_s


@pytest.fixture
def busy() -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen([sys.executable, "-c", "print(flush=True)\nwhile True: pass"], stdout=subprocess.PIPE) as it:
        assert it.stdout is not None
        it.stdout.readline()
        yield it
        it.kill()


def test_a_process_that_computes_is_told_with_the_time_it_has_used(busy: subprocess.Popen[bytes]) -> None:
    first = computing_s(busy.pid)

    assert first is not None
    assert wait_until(lambda: (computing_s(busy.pid) or 0.0) >= first + 0.1)


def test_a_process_that_is_stopped_or_dead_does_not_compute(busy: subprocess.Popen[bytes]) -> None:
    os.kill(busy.pid, signal.SIGSTOP)
    assert wait_until(lambda: computing_s(busy.pid) is None)
    os.kill(busy.pid, signal.SIGCONT)
    assert wait_until(lambda: computing_s(busy.pid) is not None)

    busy.kill()

    assert wait_until(lambda: computing_s(busy.pid) is None)
    busy.wait()
    assert computing_s(busy.pid) is None


def test_a_process_that_sleeps_does_not_compute() -> None:
    with subprocess.Popen(["/bin/cat"], stdin=subprocess.PIPE) as asleep:
        assert wait_until(lambda: computing_s(asleep.pid) is None)
