"""The recorder as the engine sees it: it holds the world back while it is behind, and never for good."""

from __future__ import annotations

from pathlib import Path

import pytest

from bringup.link import Link
from bringup.processes import Child
from bringup.recorder import PATIENCE_S, Recorder
from bringup.telemetry import Recorded, RecordingClosed
from recording.taking import Account
from recording.tick_ranges import TickRanges


@pytest.fixture
def recorder() -> Recorder:
    """Return one whose child runs."""
    found = Recorder(Path("nowhere"))
    found._child = Child("recorder", (), 4711, Link.pair()[0])
    return found


def test_the_world_may_count_on_what_has_been_recorded(recorder: Recorder) -> None:
    assert recorder.lags(3) == -1
    recorder.take(Recorded(2))
    assert recorder.lags(3) == 2
    recorder.take(Recorded(7))
    assert recorder.lags(3) == 3


def test_a_recorder_that_holds_everybody_up_for_too_long_is_given_up_once(recorder: Recorder) -> None:
    recorder.lags(3)

    assert not recorder.is_stuck(PATIENCE_S - 1.0, has_news=False)
    assert not recorder.is_stuck(0.5, has_news=True)  # it is slow, not stuck
    assert not recorder.is_stuck(PATIENCE_S - 1.0, has_news=False)
    assert recorder.is_stuck(1.5, has_news=False)
    assert not recorder.is_stuck(PATIENCE_S, has_news=False)
    assert recorder.lags(3) == 3
    assert "hung" in recorder.note()


def test_a_recorder_that_keeps_up_is_never_stuck(recorder: Recorder) -> None:
    recorder.take(Recorded(3))
    recorder.lags(3)

    assert not recorder.is_stuck(10.0 * PATIENCE_S, has_news=False)


def test_a_recorder_that_has_died_holds_nobody_up(recorder: Recorder) -> None:
    child = recorder._child
    assert child is not None
    child.status = -9

    assert "is not recorded any more" in recorder.bury(child)
    assert recorder.lags(3) == 3
    assert "SIGKILL" in recorder.note()


def test_the_note_tells_what_came_of_it(recorder: Recorder) -> None:
    assert recorder.note() == "recording: was not finished"
    recorder.take(RecordingClosed(Account({"/clock": TickRanges([0, 1])}, {}, messages=2)))
    assert recorder.note() == "recording: 2 messages on 1 topics, none lost"
