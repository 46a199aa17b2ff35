from __future__ import annotations

from studies.lps_cells import Cell, Design, Experiment, Run, SweepKind, Trial, cells, mission_cells, sweeps
from swarm_agent.localization.config import LpsMode
from swarm_sim.config import RangingModel


def cell(mode: LpsMode = LpsMode.FIXES, period_s: float = 3.0, **changes: object) -> Cell:
    return Cell(experiment=Experiment.FORMATION, mode=mode, period_s=period_s, **changes)  # type: ignore[arg-type]


def test_each_cell_is_run_once_although_sweeps_share_the_base_point() -> None:
    everything = cells(Design())

    assert len(everything) == len(set(everything))
    assert all(cell() in sweep.cells for sweep in sweeps(Design()))


def test_the_default_has_every_mode_at_the_periods_of_the_thesis() -> None:
    (period_sweep,) = (sweep for sweep in sweeps(Design()) if sweep.kind is SweepKind.PERIOD)

    assert {(c.mode, c.period_s) for c in period_sweep.cells} == {
        *((mode, period) for mode in LpsMode for period in (3.0, 5.0, 8.0)),
        *((mode, 0.0) for mode in LpsMode if mode is not LpsMode.LITERAL),
    }


def test_a_sweep_varies_one_quantity_per_mode_and_period() -> None:
    for sweep in sweeps(Design()):
        for one in {(c.mode, c.period_s) for c in sweep.cells} if sweep.kind is not SweepKind.PERIOD else ():
            own = [c for c in sweep.cells if (c.mode, c.period_s) == one]
            varied = [c.share if sweep.kind is SweepKind.SHARE else c.sigma_m for c in own]
            fixed = {c.sigma_m if sweep.kind is SweepKind.SHARE else c.share for c in own}
            assert varied == sorted(set(varied))
            assert len(fixed) == 1


def test_only_the_mode_of_the_thesis_ranges_from_noisy_positions() -> None:
    assert {mode for mode in LpsMode if cell(mode).ranging is RangingModel.POSITION} == {LpsMode.LITERAL}


def test_missions_are_about_the_best_mode_that_is_wanted() -> None:
    assert {c.mode for c in mission_cells(Design())} == {LpsMode.COOPERATIVE}
    assert {c.mode for c in mission_cells(Design(modes=(LpsMode.LITERAL, LpsMode.FIXES)))} == {LpsMode.FIXES}


def test_an_experiment_that_is_not_wanted_has_no_cells() -> None:
    assert {c.experiment for c in cells(Design(experiments=(Experiment.MISSION,)))} == {Experiment.MISSION}
    assert {c.experiment for c in cells(Design(experiments=(Experiment.FORMATION,)))} == {Experiment.FORMATION}


def test_different_runs_have_different_keys() -> None:
    other_trials = (Trial(robots=6), Trial(duration_s=90.0), Trial(warm_up_s=30.0))
    runs = [Run(c, seed, Trial()) for c in cells(Design()) for seed in (1, 2)]
    runs += [Run(cell(), 1, trial) for trial in other_trials]

    assert len({run.key for run in runs}) == len(runs)
