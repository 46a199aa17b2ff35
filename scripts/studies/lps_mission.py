"""Experiment `mission`: the whole system, in one process, with the position estimates in the loop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bringup.layout import sensor_carriers
from bringup.resolution import resolve
from bringup.results import WARM_UP_S, formation_metrics
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario
from studies.headless_mission import ENGINE, run_to_verdict
from studies.lps_cells import Cell, Trial
from studies.lps_formation import SCENARIO, overrides_of
from studies.lps_scores import Scores, score
from swarm_sim.metrics.trace import Trace


def run_mission(cell: Cell, seed: int, trial: Trial) -> Scores:
    """Return the scores of one cell and seed: the mission runs until it is achieved, or its time is over."""
    scenario = resolve(*load_scenario(SCENARIO, overrides_of(cell, seed, trial.robots)))
    outcome = run_to_verdict(scenario)
    # No wall time gets into the scores: equal seeds give equal numbers.
    metrics = formation_metrics(scenario, ENGINE, outcome)
    settled, bottleneck = metrics.settling_time_s, metrics.bottleneck_time_s
    return replace(
        _localization(scenario, outcome.recorder.trace()),
        achieved=metrics.achieved,
        collisions=metrics.collisions,
        displacement_ratio=metrics.displacement_ratio,
        settling_ratio=settled / bottleneck if settled is not None and bottleneck else None,
    )


def _localization(scenario: Scenario, trace: Trace) -> Scores:
    """Return how well the live robots without position sensor knew where they were, after the warm-up."""
    carriers = sensor_carriers(scenario)
    is_blind = np.array([robot not in carriers for robot in trace.robots])
    counts = trace.alive & is_blind & (trace.tick_times >= WARM_UP_S)[:, None]
    # Nobody is left out as lost: the mission promises errors of the swarm as it is.
    return score(trace.estimates, trace.covariances, trace.tick_positions, counts, np.ones_like(counts))
