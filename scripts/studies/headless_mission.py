"""One mission in this process, from the first tick to the verdict, with nobody watching."""

from __future__ import annotations

import time

from bringup.compose import ScenarioActors
from bringup.formation import camera_view
from bringup.inprocess import InProcessEngine
from bringup.results import Outcome, Timing
from bringup.scenario import Scenario
from bringup.supervisor import Supervisor, Verdict
from swarm_sim.metrics.trace import TraceRecorder

ENGINE = "inprocess"
"""What metrics call the engine."""


def run_to_verdict(scenario: Scenario) -> Outcome:
    """Run a resolved scenario until it is achieved, or its time is over."""
    actors = ScenarioActors(scenario)
    recorder = TraceRecorder(actors.robots, scenario.sim.period_s, camera_view(scenario))
    supervisor = Supervisor(actors.robots, scenario.success, scenario.sim.period_s, scenario.duration_s)
    verdict: Verdict | None = None
    with InProcessEngine(actors) as engine:
        began = time.monotonic()
        ticks = engine.ticks()
        while verdict is None:
            record = next(ticks)
            recorder.record(record.truth, record.reports, record.camera)
            verdict = supervisor.watch(record)
        return Outcome(recorder, supervisor, verdict, Timing(engine.startup_s, time.monotonic() - began))
