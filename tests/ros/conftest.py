"""Runs every test of this folder in a process of its own, forked from a process in which ROS never started.

A process that has used ROS cannot fork one that uses it, and a crash in the middleware ends its process; neither may
depend on which tests ran before.
"""

from __future__ import annotations

import os
import pickle
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from _pytest.runner import runtestprotocol
from leftovers import orphaned, shared_memory, wait_until

from bringup.domain_guard import DomainGuard
from swarm_msgs_py.errors import ConfigError


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> bool | None:
    """Run one test in a forked child, and report what it reports."""
    if os.path.dirname(__file__) != str(item.path.parent):
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in _forked_reports(item):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _forked_reports(item: pytest.Item) -> list[Any]:
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            reports = runtestprotocol(item, log=False, nextitem=None)
            plain = [item.config.hook.pytest_report_to_serializable(config=item.config, report=r) for r in reports]
            with os.fdopen(writing, "wb") as pipe:
                pickle.dump(plain, pipe)
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        data = pipe.read()
    _, status = os.waitpid(child, 0)
    if not data:
        return [_crash(item, os.waitstatus_to_exitcode(status))]
    hook = item.config.hook
    return [hook.pytest_report_from_serializable(config=item.config, data=plain) for plain in pickle.loads(data)]


@pytest.fixture
def nothing_left(domain_id: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fail if a child, a temporary file, a file in shared memory or a taken ROS domain outlives the test."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    before = shared_memory()
    yield
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)
    assert list(tmp_path.iterdir()) == []
    assert orphaned(shared_memory() - before) == set()
    assert wait_until(lambda: _is_free(domain_id))  # the threads of a killed process end one after the other


def _is_free(domain: int) -> bool:
    guard = DomainGuard(domain)
    try:
        guard.acquire()
    except ConfigError:
        return False
    guard.release()
    return True


def _crash(item: pytest.Item, code: int) -> pytest.TestReport:
    text = f"the process of the test ended with {code} before it could report"
    return pytest.TestReport(item.nodeid, item.location, {}, "failed", text, "call")
