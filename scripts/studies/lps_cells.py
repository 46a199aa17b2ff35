"""What the study of the local positioning system (LPS) measures: its cells, and the sweeps that they come from.

A *cell* is one point of the parameter space; every cell is simulated with the same seeds. Sweeps share cells: the base
point belongs to each of them and is run once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum

from swarm_agent.localization.config import LpsMode
from swarm_sim.config import RangingModel

BASE_PERIOD_S = 3.0
"""Localization period at which beacon share and noise are varied (reference of the thesis)."""

BASE_SHARE = 0.15
"""Share of the robots that carry a position sensor (thesis section 4.2): 8 of 50."""

BASE_SIGMA_M = 2.0
"""Noise of a range, or of the position that stands in for ranges, mode literal (thesis section 4.2) [m]."""

CONTROL_RATE = 0.0
"""Localization period that means: at every control tick [s]."""

RANGE_MODES = (LpsMode.FIXES, LpsMode.RANGE_EKF, LpsMode.COOPERATIVE)


class Experiment(Enum):
    """Where errors are measured."""

    FORMATION = "formation"
    """Robots stand in (or wander about) their places in a shape; only localization runs."""
    MISSION = "mission"
    """The whole system forms a shape from scattered starts, with the estimates in the loop."""


class Motion(Enum):
    """What robots do in experiment `formation`."""

    REST = "rest"
    """They stand, but do not know it: only inertial sensor, fixes and ranges are used, as in motion."""
    PARKED = "parked"
    """They stand, and know that they were told to."""
    WANDER = "wander"
    """They drive about their places."""


class SweepKind(Enum):
    """What is varied."""

    PERIOD = "period"
    SHARE = "share"
    NOISE = "noise"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One point of the parameter space.

    Attributes
    ----------
    experiment : Experiment
    mode : LpsMode
    period_s : float
        Between two localizations; `CONTROL_RATE` for every tick [s].
    share : float
        Share of the robots that are beacons.
    sigma_m : float
        Noise, as the sensors make it and as the filters believe it to be [m].
    motion : Motion
    """

    experiment: Experiment
    mode: LpsMode
    period_s: float
    share: float = BASE_SHARE
    sigma_m: float = BASE_SIGMA_M
    motion: Motion = Motion.REST

    @property
    def ranging(self) -> RangingModel:
        """What is noisy: the thesis simulates positions, not ranges, and so does its mode here."""
        return RangingModel.POSITION if self.mode is LpsMode.LITERAL else RangingModel.RANGE

    @property
    def key(self) -> str:
        """What tells this cell from others, for people and for the file of results."""
        period = f"{self.period_s:g} s" if self.period_s else "control rate"
        parts = (self.experiment.value, self.mode.value, period, f"share {self.share:g}", f"noise {self.sigma_m:g} m")
        return ", ".join(parts if self.motion is Motion.REST else (*parts, self.motion.value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """What all cells of a study have in common.

    Attributes
    ----------
    robots : int
        Size of the swarm, in the thesis' mix of types.
    duration_s : float
        Simulated time of experiment `formation` [s].
    warm_up_s : float
        Samples before this do not count in it [s].
    """

    robots: int = 50
    duration_s: float = 180.0
    warm_up_s: float = 60.0


@dataclass(frozen=True, slots=True)
class Run:
    """One simulation of a cell.

    Attributes
    ----------
    cell : Cell
    seed : int
    trial : Trial
    """

    cell: Cell
    seed: int
    trial: Trial

    @property
    def key(self) -> str:
        """What tells this run from others in the file of results."""
        trial = self.trial
        extent = f"{trial.robots} robots"
        if self.cell.experiment is Experiment.FORMATION:
            extent += f", {trial.warm_up_s:g} to {trial.duration_s:g} s"
        return f"{self.cell.key}, {extent}, seed {self.seed}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """What the operator wants to have measured.

    Attributes
    ----------
    experiments : tuple of Experiment
    sweeps : tuple of SweepKind
        Of experiment `formation`.
    modes : tuple of LpsMode
    periods_s, mission_periods_s : tuple of float
        Localization periods of the period sweep, and of missions [s].
    shares : tuple of float
        Beacon shares of the share sweep.
    sigmas_m : tuple of float
        Noises of the noise sweep [m].
    motion : Motion
    """

    experiments: tuple[Experiment, ...] = tuple(Experiment)
    sweeps: tuple[SweepKind, ...] = tuple(SweepKind)
    modes: tuple[LpsMode, ...] = tuple(LpsMode)
    periods_s: tuple[float, ...] = (CONTROL_RATE, 3.0, 5.0, 8.0)
    mission_periods_s: tuple[float, ...] = (CONTROL_RATE, BASE_PERIOD_S)
    shares: tuple[float, ...] = (0.06, 0.1, BASE_SHARE, 0.2, 0.3, 0.5)
    sigmas_m: tuple[float, ...] = (0.5, 1.0, BASE_SIGMA_M, 3.0, 4.0)
    motion: Motion = Motion.REST


@dataclass(frozen=True, slots=True)
class Sweep:
    """Cells that differ in one quantity and in the mode.

    Attributes
    ----------
    kind : SweepKind
    cells : tuple of Cell
        By mode, then ascending.
    """

    kind: SweepKind
    cells: tuple[Cell, ...] = field(default=())


def sweeps(design: Design) -> tuple[Sweep, ...]:
    """Return the sweeps of experiment `formation`, none if it is not wanted."""
    if Experiment.FORMATION not in design.experiments:
        return ()
    cells_of = {SweepKind.PERIOD: _period_cells, SweepKind.SHARE: _share_cells, SweepKind.NOISE: _noise_cells}
    return tuple(Sweep(kind, tuple(cells_of[kind](design))) for kind in design.sweeps)


def mission_cells(design: Design) -> tuple[Cell, ...]:
    """Return the cells of experiment `mission`; they are about the best mode that is wanted."""
    if Experiment.MISSION not in design.experiments:
        return ()
    mode = LpsMode.COOPERATIVE if LpsMode.COOPERATIVE in design.modes else design.modes[-1]
    periods = sorted(set(design.mission_periods_s))
    return tuple(Cell(experiment=Experiment.MISSION, mode=mode, period_s=period) for period in periods)


def cells(design: Design) -> tuple[Cell, ...]:
    """Return all cells, each once, in the order in which they are worth having."""
    everything = [*mission_cells(design), *(cell for sweep in sweeps(design) for cell in sweep.cells)]
    return tuple(dict.fromkeys(everything))


def _period_cells(design: Design) -> Iterator[Cell]:
    for mode in design.modes:
        for period in sorted(set(design.periods_s)):
            # The thesis never localizes at the control rate; its fixes are as noisy then, and ten times as many.
            if mode is not LpsMode.LITERAL or period > CONTROL_RATE or design.modes == (LpsMode.LITERAL,):
                yield _formation(design, mode, period)


def _share_cells(design: Design) -> Iterator[Cell]:
    for mode, period in _variants(design.modes):
        for share in sorted(set(design.shares)):
            yield _formation(design, mode, period, share=share)


def _noise_cells(design: Design) -> Iterator[Cell]:
    for mode, period in _variants(design.modes):
        for sigma in sorted(set(design.sigmas_m)):
            yield _formation(design, mode, period, sigma_m=sigma)


def _variants(modes: Sequence[LpsMode]) -> Iterator[tuple[LpsMode, float]]:
    """Yield each mode at the base period, and the product's default: cooperative, at the control rate."""
    for mode in modes:
        yield mode, BASE_PERIOD_S
    if LpsMode.COOPERATIVE in modes:
        yield LpsMode.COOPERATIVE, CONTROL_RATE


def _formation(
    design: Design, mode: LpsMode, period_s: float, share: float = BASE_SHARE, sigma_m: float = BASE_SIGMA_M
) -> Cell:
    return Cell(
        experiment=Experiment.FORMATION,
        mode=mode,
        period_s=period_s,
        share=share,
        sigma_m=sigma_m,
        motion=design.motion,
    )
