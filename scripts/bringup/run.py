"""One run from start to verdict, with whatever engine; and its results on disk."""

from __future__ import annotations

import io
import time

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


def execute(scenario: Scenario, engine: Engine, interruption: Interruption, progress: Progress) -> Outcome:
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
                began = time.monotonic()
                verdict = _watch(scenario, engine, recorder, supervisor, progress)
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


def _watch(
    scenario: Scenario, engine: Engine, recorder: TraceRecorder, supervisor: Supervisor, progress: Progress
) -> Verdict:
    for record in engine.ticks():
        recorder.record(record.truth, record.reports)
        verdict = supervisor.watch(record)
        progress.show(record, record.truth.time + scenario.sim.period_s, supervisor.at_goal)
        if verdict is not None:
            return verdict
    return Verdict(False, "the engine ended before the run did; see the alerts for why")


def write_results(
    scenario: Scenario, engine: str, outcome: Outcome, folder: RunFolder, interruption: Interruption
) -> FormationMetrics:
    """Write what a run left behind, the most important first; after an interruption no picture is drawn."""
    folder.write("scenario.yaml", dump_scenario(scenario).encode())
    metrics = formation_metrics(scenario, engine, outcome)
    folder.write("metrics.json", metrics.to_json().encode())
    trace, plan = outcome.recorder.trace(), outcome.supervisor.plan
    buffer = io.BytesIO()
    np.savez(buffer, **trajectory_arrays(scenario, trace, plan))  # type: ignore[arg-type]  # names never clash with it
    folder.write("trajectories.npz", buffer.getvalue())
    try:
        with interruption.welcome():
            # Drawing takes a second to import; a run that was interrupted has no time for it.
            from bringup.figure import run_figure  # noqa: PLC0415

            folder.write("figure.png", run_figure(scenario, trace, plan, metrics))
    except KeyboardInterrupt:
        pass
    return metrics
