"""One run of a batch: all that a worker process needs to know."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cache

from batches.cells import Run
from bringup.resolution import resolve
from bringup.results import FormationMetrics, Outcome, formation_metrics
from studies.code_version import code_version
from studies.headless_mission import ENGINE, run_to_verdict
from swarm_msgs_py.errors import ConfigError, ShapeError

TIMING = frozenset({"wall_time_s", "real_time_factor", "startup_s"})
"""Metrics that depend on the machine; all others are the same wherever a run is made."""

STARTS_DIGITS = 16


@dataclass(frozen=True, slots=True)
class Performed:
    """What came of one run.

    Attributes
    ----------
    metrics : mapping
        By name, as ``metrics.json`` has them, without `TIMING`; equal runs of equal code have equal ones, to the byte.
    starts : str
        Fingerprint of where the robots stood at the start; empty if the run was refused.
    timing : mapping
        `TIMING` by name, and ``run_s``: all that the run took, from the scenario to the metrics [s].
    code : str
        Version of the code that made it.
    """

    metrics: Mapping[str, object]
    starts: str
    timing: Mapping[str, object]
    code: str

    def as_record(self) -> dict[str, object]:
        """Return it as a line of the file of results."""
        return {"metrics": dict(self.metrics), "starts": self.starts, "timing": dict(self.timing)}


def perform(run: Run) -> Performed:
    """Simulate one run. A start that cannot be made counts as not achieved: to leave it out would flatter."""
    began = time.perf_counter()
    try:
        scenario = resolve(run.scenario, run.cell.origin)
    except (ConfigError, ShapeError) as error:
        return Performed(_refused(run, str(error)), "", {}, _version())
    outcome = run_to_verdict(scenario)
    numbers = asdict(formation_metrics(scenario, ENGINE, outcome))
    timing = {name: numbers.pop(name) for name in sorted(TIMING)}
    timing["run_s"] = time.perf_counter() - began
    return Performed(numbers, _starts(outcome), timing, _version())


def _starts(outcome: Outcome) -> str:
    """Return the fingerprint of the first positions, in whole nanometers."""
    first = outcome.recorder.trace().positions[0]
    return hashlib.sha256((first * 1e9).round().astype("<i8").tobytes()).hexdigest()[:STARTS_DIGITS]


def _refused(run: Run, reason: str) -> dict[str, object]:
    scenario = run.cell.scenario
    known: dict[str, object] = {
        "scenario": scenario.name,
        "family": scenario.family.value,
        "method": scenario.method,
        "seed": run.seed,
        "engine": ENGINE,
        "physics": scenario.sim.physics.backend.value,
        "robots": scenario.robots.count,
        "achieved": False,
        "reason": f"refused: {reason}",
    }
    return {field.name: known.get(field.name) for field in fields(FormationMetrics) if field.name not in TIMING}


@cache
def _version() -> str:
    """Return the version of the code that this process runs; reading it all takes a while, once."""
    return code_version()
