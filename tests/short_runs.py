"""Runs without ROS that get Ctrl-C after some simulated time, so that nothing of the scenario has to be left out."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from typing import Any

import pytest

from bringup.engine import TickRecord
from bringup.inprocess import InProcessEngine

INTERRUPTED = 130
"""Exit code of such a run."""


def interrupt_after(seconds: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let runs without ROS get Ctrl-C after so much simulated time [s]."""
    whole = InProcessEngine.ticks

    def some(engine: InProcessEngine) -> Iterator[TickRecord[Any, Any]]:
        for record in whole(engine):
            yield record
            if record.truth.time >= seconds:
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(InProcessEngine, "ticks", some)
