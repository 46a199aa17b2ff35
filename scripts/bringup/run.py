"""One run from start to verdict, with whatever engine; and its results on disk."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bringup.engine import Engine
from bringup.interruption import Interruption
from bringup.progress import Progress
from bringup.results import FormationMetrics, Outcome, Timing, formation_metrics
from bringup.run_folder import RunFolder, trajectory_arrays
from bringup.scenario import Scenario
from bringup.scenario_file import dump_scenario
from bringup.supervisor import Supervisor, Verdict
from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.trace import TraceRecorder

KEEP_S = 20.0  # least wall time between two saves of a run that goes on
KEEP_SHARE = 0.03  # of the wall time that saving may take


class Journal:
    """Keeps what is on disk up to date while a run goes on, so that its sudden death leaves a readable folder.

    Parameters
    ----------
    scenario : Scenario
        Resolved.
    engine : str
        Name of the engine.
    folder : RunFolder
    progress : Progress
        Hears of it once when the disk does not take something; the run goes on.
    """

    def __init__(self, scenario: Scenario, engine: str, folder: RunFolder, progress: Progress) -> None:
        self._scenario = scenario
        self._engine = engine
        self._folder = folder
        self._progress = progress
        self._due = 0.0  # seconds of wall time after the first tick
        self._is_told = False

    def begin(self) -> None:
        """Write the scenario."""
        self._attempt(lambda: _write_scenario(self._scenario, self._folder))

    def keep(self, recorder: TraceRecorder, supervisor: Supervisor, timing: Timing) -> None:
        """Write metrics and trajectories so far, if the last time is long enough ago."""
        if timing.wall_time_s < self._due:
            return
        began = time.monotonic()
        verdict = supervisor.unfinished(len(recorder) * self._scenario.sim.period_s)
        outcome = Outcome(recorder, supervisor, verdict, timing)
        self._attempt(lambda: _write_record(self._scenario, self._engine, outcome, self._folder))
        self._due = timing.wall_time_s + max(KEEP_S, (time.monotonic() - began) / KEEP_SHARE)

    def _attempt(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as error:
            if not self._is_told:
                self._is_told = True
                self._progress.say(
                    f"{self._folder.path}: cannot be written for now ({error.strerror}); the run goes on"
                )


def execute(
    scenario: Scenario, engine: Engine, interruption: Interruption, progress: Progress, journal: Journal
) -> Outcome:
    """Run a resolved scenario to its verdict; the engine is stopped when this returns.

    Raises
    ------
    SwarmError
        If the engine refuses to start.
    """
    robots = tuple(NodeId(robot) for robot in range(scenario.robots.count))
    recorder = TraceRecorder(robots, scenario.sim.period_s)
    supervisor = Supervisor(robots, scenario.success, scenario.sim.period_s, scenario.duration_s)
    began: float | None = None
    try:
        try:
            with interruption.welcome():
                engine.__enter__()
                journal.begin()
                began = time.monotonic()
                verdict = _watch(scenario, engine, recorder, supervisor, progress, journal)
        except KeyboardInterrupt:
            verdict = supervisor.interrupted(len(recorder) * scenario.sim.period_s)
        except SwarmError as error:
            if began is None:
                raise
            verdict = Verdict(False, str(error))
        wall = 0.0 if began is None else time.monotonic() - began
    finally:
        # Not a `with` statement: an interruption may end the start half way, and what was started must stop.
        engine.__exit__(None, None, None)
    return Outcome(recorder, supervisor, verdict, Timing(engine.startup_s, wall))


def _watch(  # noqa: PLR0913, PLR0917 - all that looks at a tick
    scenario: Scenario,
    engine: Engine,
    recorder: TraceRecorder,
    supervisor: Supervisor,
    progress: Progress,
    journal: Journal,
) -> Verdict:
    began = time.monotonic()
    for record in engine.ticks():
        recorder.record(record.truth, record.reports, record.camera)
        verdict = supervisor.watch(record)
        record = replace(record, alerts=(*record.alerts, *supervisor.goal_agreement.alerts))  # noqa: PLW2901
        progress.show(record, record.truth.time + scenario.sim.period_s, supervisor.at_goal)
        if verdict is not None:
            return verdict
        journal.keep(recorder, supervisor, Timing(engine.startup_s, time.monotonic() - began))
    return Verdict(False, "the engine ended before the run did; see the alerts for why")


def write_results(
    scenario: Scenario, engine: str, outcome: Outcome, folder: RunFolder, interruption: Interruption
) -> FormationMetrics:
    """Write what a run left behind, the most important first; after an interruption no picture is drawn."""
    _write_scenario(scenario, folder)
    metrics = _write_record(scenario, engine, outcome, folder)
    try:
        with interruption.welcome():
            # Drawing takes a second to import; a run that was interrupted has no time for it.
            from bringup.figure import run_figure  # noqa: PLC0415

            folder.write("figure.png", run_figure(scenario, outcome.recorder.trace(), outcome.supervisor.plan, metrics))
    except KeyboardInterrupt:
        pass
    return metrics


def _write_scenario(scenario: Scenario, folder: RunFolder) -> None:
    folder.write("scenario.yaml", dump_scenario(scenario).encode())


def _write_record(scenario: Scenario, engine: str, outcome: Outcome, folder: RunFolder) -> FormationMetrics:
    """Write the numbers and the motion of a run, finished or not."""
    metrics = formation_metrics(scenario, engine, outcome)
    folder.write("metrics.json", metrics.to_json().encode())
    buffer = io.BytesIO()
    arrays = trajectory_arrays(scenario, outcome.recorder.trace(), outcome.supervisor.plan)
    np.savez(buffer, **arrays)  # type: ignore[arg-type]  # names never clash with it
    folder.write("trajectories.npz", buffer.getvalue())
    return metrics
