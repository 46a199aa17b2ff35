"""The recorder as the engine sees it: a child that may hold the world back, and must not stop the run."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from bringup.engine import Actors, TickRecord
from bringup.patience import Patience
from bringup.processes import Child, ProcessGroup
from bringup.telemetry import Recorded, RecordingClosed, Stop
from recording.audit import Audit
from recording.taking import Account
from swarm_msgs_py.ros.dialect import Dialect
from swarm_msgs_py.topics import channels_by_topic

PATIENCE_S = 20.0  # without a word from a recorder that everybody waits for
CLOSE_S = 10.0  # for it to finish the bag: half a second for fifty robots, where there is nothing else to do
GIVEN_UP_S = 1.0  # the same for one that has hung before


class Recorder:
    """Starts the recorder, says how far the world may run ahead of it, ends it, and tells what came of it.

    Parameters
    ----------
    path : Path
        Folder of the bag, not there yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._child: Child | None = None
        self._audit = Audit()
        self._account: Account | None = None
        self._patience = Patience(PATIENCE_S)
        self._tick = -1
        self._is_behind = False
        self._end = ""

    def start(self, group: ProcessGroup, actors: Actors, dialect: Dialect[Any, Any, Any]) -> None:
        """Fork it."""
        from bringup.recorder_child import run_recorder  # noqa: PLC0415 - what writes bags takes long to load

        path, period_s = self._path, actors.period_s
        has_camera = actors.image_hz is not None
        channels = channels_by_topic(
            tuple(sorted(actors.robots)), dialect.sensors, dialect.shown, has_camera=has_camera
        )
        self._audit = Audit(dialect.shown)
        self._child = group.start("recorder", (), lambda link: run_recorder(link, path, channels, period_s))

    def is_me(self, child: Child) -> bool:
        """Return whether a child is the recorder."""
        return child is self._child

    def expect(self, record: TickRecord[Any, Any]) -> None:
        """Take note of a tick that it must have recorded."""
        self._audit.expect(record)

    def take(self, message: object) -> None:
        """Take what the recorder says."""
        if isinstance(message, Recorded):
            self._tick = message.tick
        elif isinstance(message, RecordingClosed):
            self._account = message.account

    def lags(self, tick: int) -> int:
        """Return the tick up to which the world may count on what has been recorded, `tick` at most."""
        self._is_behind = self._is_waited_for and self._tick < tick
        return min(self._tick, tick) if self._is_waited_for else tick

    def is_stuck(self, waited_s: float, *, has_news: bool) -> bool:
        """Take in a wait; return True once if the recorder has held up the run for too long. It goes on without."""
        if not self._is_waited_for or not self._patience.is_out(waited_s, has_news=has_news or not self._is_behind):
            return False
        self._end = f"recorder: hung, no word for {PATIENCE_S:g} s; the recording has holes"
        return True

    def bury(self, child: Child) -> str:
        """Let the run go on without the recorder, which has died; return the line that says so."""
        self._end = f"{child.epitaph()}; what it had written is in {self._path}"
        return f"{child.epitaph()}; the run goes on and is not recorded any more"

    def finish(self, group: ProcessGroup) -> None:
        """Have the bag finished, while those who fill it are still there; may be called again."""
        child = self._child
        if child is None or child.status is not None or self._account is not None:
            return
        child.link.send(Stop())
        end = time.monotonic() + (GIVEN_UP_S if self._end else CLOSE_S)
        while self._account is None and child.status is None and (left := end - time.monotonic()) > 0.0:
            for sender, message in group.poll(left):
                if sender is child and message is not None:
                    self.take(message)

    def note(self) -> str:
        """Return what came of it, in a line."""
        if self._account is not None:
            return self._audit.compare(self._account).line()  # also if it has hung, and gone on in the end
        return f"recording: {self._end or 'was not finished'}"

    @property
    def _is_waited_for(self) -> bool:
        return self._child is not None and self._child.status is None and not self._end
