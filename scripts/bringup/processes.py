"""Child processes that are forked from this one, talk over a link, and never outlive it.

Forking a process that has already imported everything starts fifty nodes in the time in which fifty fresh interpreters
would start two. Nothing of ROS may be initialized before: threads do not survive a fork.
"""

from __future__ import annotations

import ctypes
import gc
import os
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NoReturn

from bringup.link import Link
from bringup.telemetry import Failed, Stop
from swarm_msgs_py.types import NodeId

ASK_S, TERMINATE_S, KILL_S = 1.5, 0.6, 0.4
"""How long children are given to end after being asked, after SIGTERM, and after SIGKILL [s]; together below 3 s."""

LAST_WORDS_S = 0.5  # for a child that fails to say why
_REAP_INTERVAL_S = 0.01
_PR_SET_PDEATHSIG = 1
_WELCOME_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_CRASHED = 1

Main = Callable[[Link], None]


@dataclass(slots=True, eq=False)
class Child:
    """One child process.

    Attributes
    ----------
    name : str
        What it is, for people.
    nodes : tuple of NodeId
        Whose electronics it stands for; empty for the world.
    pid : int
    link : Link
        This end of its connection.
    status : int or None
        Exit code, or minus the signal that ended it; None while it runs.
    failure : str
        What it said before it failed.
    """

    name: str
    nodes: tuple[NodeId, ...]
    pid: int
    link: Link
    status: int | None = None
    failure: str = ""

    def epitaph(self) -> str:
        """Return how it ended, in a line."""
        if self.failure:
            return f"{self.name} (process {self.pid}) failed: {self.failure}"
        status = self.status or 0
        how = f"signal {-status} ({_signal_name(-status)})" if status < 0 else f"exit code {status}"
        return f"{self.name} (process {self.pid}) died: {how}"


class ProcessGroup:
    """Starts, watches and stops children."""

    def __init__(self) -> None:
        self.children: list[Child] = []

    def start(self, name: str, nodes: tuple[NodeId, ...], main: Main) -> Child:
        """Fork a child that runs `main` with its end of a link, then ends."""
        here, there = Link.pair()
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        with _signals_held():  # a handler of this process must not run in the child, nor tear this apart
            pid = os.fork()
            if pid == 0:
                for link in (here, *(child.link for child in self.children)):
                    link.close()  # else the children would not notice when this process is gone
                _run_child(main, there, parent)
            child = Child(name, nodes, pid, here)
            self.children.append(child)
        there.close()
        return child

    def poll(self, duration_s: float) -> list[tuple[Child, Any]]:
        """Return what the children have sent, and None last from each that has died.

        Waits until there is something, `duration_s` at most. A death closes the link, so it wakes this at once.
        """
        running = {child.link.fileno(): child for child in self.children if child.status is None}
        events: list[tuple[Child, Any]] = []
        for ready in select.select(list(running), [], [], duration_s)[0]:
            child = running[ready]
            for record in child.link.receive():
                if isinstance(record, Failed):
                    child.failure = record.reason
                else:
                    events.append((child, record))
            if not child.link.is_open:
                self._bury(child)
                events.append((child, None))
        return events

    def stop(self) -> None:
        """End all children: ask, terminate, kill. Returns within 3 s, and no child is left."""
        for child in self._running():
            child.link.send(Stop())
        self._await_end(ASK_S)
        for number, patience_s in ((signal.SIGTERM, TERMINATE_S), (signal.SIGKILL, KILL_S)):
            for child in self._running():
                os.kill(child.pid, number)
            self._await_end(patience_s)
        for child in self.children:
            child.link.close()

    def _running(self) -> list[Child]:
        return [child for child in self.children if child.status is None]

    def _await_end(self, duration_s: float) -> None:
        deadline = time.monotonic() + duration_s
        while self._running() and time.monotonic() < deadline:
            links = [child.link for child in self._running() if child.link.is_open]
            for link in select.select(links, [], [], _REAP_INTERVAL_S)[0]:
                link.receive()  # nobody waits for these words any more, but a full socket would keep a child alive
            for child in self._running():
                pid, status = os.waitpid(child.pid, os.WNOHANG)
                if pid:
                    child.status = os.waitstatus_to_exitcode(status)

    def _bury(self, child: Child) -> None:
        """Learn how a child ended that has hung up; one that hung up and lives on is of no use and is killed."""
        deadline = time.monotonic() + LAST_WORDS_S
        while child.status is None:
            pid, status = os.waitpid(child.pid, os.WNOHANG)
            if pid:
                child.status = os.waitstatus_to_exitcode(status)
            elif time.monotonic() > deadline:
                os.kill(child.pid, signal.SIGKILL)
                child.status = os.waitstatus_to_exitcode(os.waitpid(child.pid, 0)[1])
            else:
                select.select([], [], [], _REAP_INTERVAL_S)
        child.link.close()


def outlive_parent() -> None:
    """Let this child notice the end of its parent by its link, instead of ending with it at once."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, 0)


@contextmanager
def _signals_held() -> Iterator[None]:
    """Hold back interrupts until the end of the block."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _WELCOME_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _run_child(main: Main, link: Link, parent: int) -> NoReturn:
    """Live as a child process; never returns into the parent's code."""
    status = _CRASHED
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent decides
        signal.signal(signal.SIGHUP, signal.SIG_IGN)  # so does the end of the terminal
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _WELCOME_SIGNALS)
        if os.getppid() == parent:  # else it died before it could be tied to this process
            gc.freeze()  # what was imported stays; looking through it again and again would copy shared memory
            main(link)
            status = 0
    except BaseException as error:  # noqa: BLE001 - the end of a process: whatever it was, it is reported
        traceback.print_exc()
        link.send(Failed.of(error))
    finally:
        link.flush_within(LAST_WORDS_S)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"
