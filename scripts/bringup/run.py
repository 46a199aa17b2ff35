"""One run from start to verdict, with whatever engine and family; and its results on disk."""

from __future__ import annotations

import io
import json
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from bringup.engine import Engine
from bringup.family import Account, AnyScenario, Metrics
from bringup.interruption import Interruption
from bringup.progress import Progress
from bringup.run_folder import RunFolder
from bringup.scenario_file import dump_scenario
from bringup.verdict import Timing, Verdict
from reports.page import report_page
from reports.run_record import RunRecord
from swarm_msgs_py.errors import SwarmError

KEEP_S = 20.0  # least wall time between two saves of a run that goes on
KEEP_SHARE = 0.03  # of the wall time that saving may take

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Run:
    """What is run, by what, and where to it is written.

    Attributes
    ----------
    scenario : AnyScenario
        Resolved.
    engine : str
        Name of the engine.
    account : Account
    folder : RunFolder
    """

    scenario: AnyScenario
    engine: str
    account: Account
    folder: RunFolder

    def write_scenario(self) -> None:
        """Write the scenario."""
        self.folder.write("scenario.yaml", dump_scenario(self.scenario).encode())

    def write_record(self, verdict: Verdict, timing: Timing) -> tuple[Metrics, Mapping[str, np.ndarray]]:
        """Write the numbers and the motion of the run, finished or not; return them."""
        metrics = self.account.metrics(self.engine, verdict, timing)
        self.folder.write("metrics.json", metrics_text(metrics).encode())
        buffer = io.BytesIO()
        arrays = self.account.arrays()
        np.savez(buffer, **arrays)  # type: ignore[arg-type]  # names never clash with it
        self.folder.write("trajectories.npz", buffer.getvalue())
        return metrics, arrays

    @property
    def time_s(self) -> float:
        """Simulated time that has passed [s]."""
        return self.account.ticks * self.scenario.period_s


@dataclass(frozen=True, slots=True)
class Ended:
    """A run that is over."""

    verdict: Verdict
    timing: Timing


class Journal:
    """Keeps what is on disk up to date while a run goes on, so that its sudden death leaves a readable folder.

    Parameters
    ----------
    run : Run
    progress : Progress
        Hears of it once when the disk does not take something; the run goes on.
    """

    def __init__(self, run: Run, progress: Progress) -> None:
        self._run = run
        self._progress = progress
        self._due = 0.0  # seconds of wall time after the first tick
        self._is_told = False

    def begin(self) -> None:
        """Write the scenario."""
        self._attempt(self._run.write_scenario)

    def keep(self, timing: Timing) -> None:
        """Write metrics and trajectories so far, if the last time is long enough ago."""
        if timing.wall_time_s < self._due:
            return
        began = time.monotonic()
        verdict = self._run.account.unfinished(self._run.time_s)
        self._attempt(lambda: self._run.write_record(verdict, timing))
        self._due = timing.wall_time_s + max(KEEP_S, (time.monotonic() - began) / KEEP_SHARE)

    def _attempt(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as error:
            if not self._is_told:
                self._is_told = True
                self._progress.say(
                    f"{self._run.folder.path}: cannot be written for now ({error.strerror}); the run goes on"
                )


def metrics_text(metrics: Metrics) -> str:
    """Return the text of ``metrics.json``."""
    return json.dumps(metrics.values, indent=2, allow_nan=False) + "\n"


def execute(run: Run, engine: Engine, interruption: Interruption, progress: Progress) -> Ended:
    """Run to the verdict; the engine is stopped when this returns.

    Raises
    ------
    SwarmError
        If the engine refuses to start.
    """
    began: float | None = None
    try:
        try:
            with interruption.welcome():
                engine.__enter__()
                journal = Journal(run, progress)
                journal.begin()
                began = time.monotonic()
                verdict = _watch(run, engine, progress, journal)
        except KeyboardInterrupt:
            verdict = run.account.interrupted(run.time_s)
        except SwarmError as error:
            if began is None:
                raise
            verdict = Verdict(False, str(error))
        wall = 0.0 if began is None else time.monotonic() - began
    finally:
        # Not a `with` statement: an interruption may end the start half way, and what was started must stop.
        engine.__exit__(None, None, None)
    return Ended(verdict, Timing(engine.startup_s, wall))


def _watch(run: Run, engine: Engine, progress: Progress, journal: Journal) -> Verdict:
    began, account = time.monotonic(), run.account
    for record in engine.ticks():
        verdict = account.take(record)
        record = replace(record, alerts=(*record.alerts, *account.alerts))  # noqa: PLW2901
        progress.show(record, record.truth.time + run.scenario.period_s, account.status)
        if verdict is not None:
            return verdict
        journal.keep(Timing(engine.startup_s, time.monotonic() - began))
    return Verdict(False, "the engine ended before the run did; see the alerts for why")


def write_results(run: Run, ended: Ended, interruption: Interruption, warn: Callable[[str], None]) -> Metrics:
    """Write what a run left behind, the most important first; after an interruption no picture is drawn.

    Report and figure only show what the other files hold: if one cannot be made, the run has lost nothing, and `warn`
    is told so in a line.

    Raises
    ------
    OSError
        If the disk does not take the results.
    """
    run.write_scenario()
    metrics, arrays = run.write_record(ended.verdict, ended.timing)
    record = RunRecord(dict(metrics.values), dump_scenario(run.scenario), arrays)
    try:
        _draw(run, "report.html", lambda: report_page(record), warn)
        with interruption.welcome():
            _draw(run, "figure.png", lambda: run.account.figure(metrics), warn)
    except KeyboardInterrupt:
        pass
    return metrics


def _draw(run: Run, name: str, make: Callable[[], bytes], warn: Callable[[str], None]) -> None:
    try:
        run.folder.write(name, make())
    except Exception as error:  # whatever is wrong with a picture, the numbers are there
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        logger.debug("%s could not be made", name, exc_info=True)
        warn(f"{run.folder.path / name}: could not be made ({reason}); all other results are there")
