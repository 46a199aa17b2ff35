"""Runs every test of this folder in a process of its own, forked from a process in which ROS never started.

A process that has used ROS cannot fork one that uses it, and a crash in the middleware ends its process; neither may
depend on which tests ran before.
"""

from __future__ import annotations

import os
import pickle
from typing import Any

import pytest
from _pytest.runner import runtestprotocol


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


def _crash(item: pytest.Item, code: int) -> pytest.TestReport:
    text = f"the process of the test ended with {code} before it could report"
    return pytest.TestReport(item.nodeid, item.location, {}, "failed", text, "call")
