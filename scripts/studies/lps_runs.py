"""One run of the study, whichever its experiment; all that a worker process needs to know."""

from __future__ import annotations

from collections.abc import Callable

from studies.lps_cells import Cell, Experiment, Run, Trial
from studies.lps_formation import run_formation
from studies.lps_mission import run_mission
from studies.lps_scores import Scores

EXPERIMENTS: dict[Experiment, Callable[[Cell, int, Trial], Scores]] = {
    Experiment.FORMATION: run_formation,
    Experiment.MISSION: run_mission,
}


def perform(run: Run) -> Scores:
    """Simulate one run; equal runs give equal scores, in whatever process."""
    return EXPERIMENTS[run.cell.experiment](run.cell, run.seed, run.trial)
