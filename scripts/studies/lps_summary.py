"""What the runs of each cell come to, and whether that is what the project promises."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

from studies.campaign import Record
from studies.lps_cells import BASE_PERIOD_S, CONTROL_RATE, Cell, Experiment, Run
from swarm_agent.localization.config import LpsMode

SMALLER_IS_WORSE = frozenset({"nees_share", "achieved"})
NEES_SHARE_MIN = 0.9
SEEDS_FOR_A_CLAIM = 30
"""A target speaks of the mean of at least so many seeds."""


@dataclass(frozen=True, slots=True)
class Statistic:
    """One number over the seeds of a cell.

    Attributes
    ----------
    mean, best, worst : float
        Over the seeds that have the number.
    seeds : int
        How many these are.
    """

    mean: float
    best: float
    worst: float
    seeds: int


@dataclass(frozen=True, slots=True)
class Target:
    """What one number of one cell must reach.

    Attributes
    ----------
    cell : Cell
    name : str
        Of the number, as in `studies.lps_scores.Scores`.
    limit : float
        Largest mean; the smallest one for shares.
    """

    cell: Cell
    name: str
    limit: float

    def is_met_by(self, measured: float) -> bool:
        """Return whether a mean is good enough."""
        return measured >= self.limit if self.name in SMALLER_IS_WORSE else measured <= self.limit


@dataclass(frozen=True, slots=True)
class ThesisPoint:
    """What the thesis, and a simulation of its method, say of one localization period.

    Attributes
    ----------
    period_s : float
    claimed_max_m : float
        Largest error, read from thesis figures 4.4 to 4.6 [m].
    expected_rms_m, expected_max_m : float
        What the stated noise gives with mean accelerations (erratum E12) [m].
    """

    period_s: float
    claimed_max_m: float
    expected_rms_m: float
    expected_max_m: float


THESIS = (ThesisPoint(3.0, 3.0, 1.3, 4.0), ThesisPoint(5.0, 10.0, 1.6, 5.0), ThesisPoint(8.0, 12.0, 1.9, 6.0))


def targets() -> tuple[Target, ...]:
    """Return all targets; consistency is asked of every mode."""
    limits: list[tuple[Experiment, LpsMode, float, Mapping[str, float]]] = [
        (Experiment.FORMATION, LpsMode.LITERAL, BASE_PERIOD_S, {"rms_m": 1.35, "p99_m": 3.0, "max_m": 4.6}),
        (Experiment.FORMATION, LpsMode.FIXES, BASE_PERIOD_S, {"rms_m": 1.0}),
        (Experiment.FORMATION, LpsMode.RANGE_EKF, BASE_PERIOD_S, {"rms_m": 0.9}),
        (Experiment.FORMATION, LpsMode.COOPERATIVE, BASE_PERIOD_S, {"rms_m": 0.6}),
        (Experiment.FORMATION, LpsMode.COOPERATIVE, CONTROL_RATE, {"rms_m": 0.3, "p99_m": 0.65, "max_m": 1.2}),
        (Experiment.MISSION, LpsMode.COOPERATIVE, BASE_PERIOD_S, {"rms_m": 0.6}),
        (Experiment.MISSION, LpsMode.COOPERATIVE, CONTROL_RATE, {"rms_m": 0.33}),
    ]
    return tuple(
        Target(Cell(experiment=experiment, mode=mode, period_s=period), name, limit)
        for experiment, mode, period, own in limits
        for name, limit in {**own, "nees_share": NEES_SHARE_MIN}.items()
    )


class Summary:
    """The statistics of all cells of a study.

    Parameters
    ----------
    runs : sequence of Run
        That the study consists of.
    records : mapping
        Results by key of run; those of other runs are left out, missing ones are missing.
    """

    def __init__(self, runs: Sequence[Run], records: Mapping[str, Record]) -> None:
        self._records: dict[Cell, list[Record]] = {}
        # By seed, not as they finished: sums of floats depend on their order.
        for run in sorted(runs, key=lambda run: run.seed):
            if run.key in records:
                self._records.setdefault(run.cell, []).append(records[run.key])

    def __contains__(self, cell: Cell) -> bool:
        return cell in self._records

    def seeds(self, cell: Cell) -> int:
        """Return how many runs of a cell there are."""
        return len(self._records.get(cell, ()))

    def statistic(self, cell: Cell, name: str) -> Statistic | None:
        """Return mean and worst of one number over the seeds of a cell; None where no run has it."""
        values = _numbers(record.get(name) for record in self._records.get(cell, ()))
        if not values:
            return None
        best, worst = (max(values), min(values)) if name in SMALLER_IS_WORSE else (min(values), max(values))
        return Statistic(fmean(values), best, worst, len(values))


def _numbers(values: Iterable[object]) -> list[float]:
    """Return what is a number; truth values count as 0 and 1."""
    return [float(value) for value in values if isinstance(value, int | float)]
