"""From the command line of ``lps_study.py`` to tables, a figure and an exit code."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from bringup.interruption import Interruption
from bringup.option_types import complain
from bringup.steady_stream import steady
from studies.campaign import ResultFile, completed
from studies.campaign_folder import open_results, write_files
from studies.campaign_progress import console_on, follow
from studies.lps_arguments import Arguments, parse_arguments
from studies.lps_cells import Cell, Run, cells
from studies.lps_figure import study_figure
from studies.lps_runs import perform
from studies.lps_scores import Scores
from studies.lps_summary import Summary
from studies.lps_tables import CELL_HEADER, TARGET_HEADER, as_csv, as_markdown, cell_rows, target_rows
from swarm_msgs_py.errors import ConfigError, ShapeError, SwarmError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
TABLE, CSV, FIGURE = "table.md", "table.csv", "lps-study.png"


def main(argv: Sequence[str] | None = None) -> int:
    """Run what is missing of the study, write what there is; return the exit code (0, 1, 2 or 130)."""
    with Interruption() as interruption:
        try:
            return _study(parse_arguments(sys.argv[1:] if argv is None else argv), interruption)
        except SwarmError as error:
            complain(error)
            return BAD_INPUT if isinstance(error, ConfigError | ShapeError) else FAILED
        except KeyboardInterrupt:
            print("interrupted before the start; nothing was written", file=steady(sys.stderr))
            return INTERRUPTED


def _study(arguments: Arguments, interruption: Interruption) -> int:
    """Simulate and write.

    Raises
    ------
    SwarmError
        If the input is bad, or a worker died; what was done is in the file of results then.
    """
    wanted = cells(arguments.design)
    runs = [Run(cell, seed, arguments.trial) for seed in arguments.seeds for cell in wanted]
    file = open_results(arguments.out)
    warning = file.warning(run.key for run in runs)
    if warning:
        console_on(sys.stderr).print(warning, markup=False, soft_wrap=True)
    missing = [run for run in runs if arguments.simulates and run.key not in file.records]
    try:
        if missing:
            _simulate(runs, missing, file, arguments.workers, interruption)
    except KeyboardInterrupt:
        pass
    except OSError as error:
        raise SwarmError(f"{file.path}: cannot be written ({error.strerror}); what it has is kept") from None
    summary = Summary(runs, file.records)
    _write(arguments, wanted, summary, warning)
    left = sum(run.key not in file.records for run in runs)
    note = f"{len(runs) - left} of {len(runs)} runs are done; the same command goes on with the rest" if left else ""
    _print(arguments, wanted, summary, note)
    return INTERRUPTED if interruption.requested else DONE


def _simulate(
    runs: Sequence[Run], missing: Sequence[Run], file: ResultFile, workers: int, interruption: Interruption
) -> None:
    def keep(run: Run, scores: Scores) -> None:
        file.append(run.key, scores.as_record())

    follow(
        completed(missing, perform, workers),
        keep,
        done=len(runs) - len(missing),
        total=len(runs),
        where=f"{workers} at a time",
        label=lambda run: f"seed {run.seed}, {run.cell.mode.value}",
        interruption=interruption,
    )


def _write(arguments: Arguments, wanted: Sequence[Cell], summary: Summary, warning: str) -> None:
    """Write tables and figure; whoever looks sees whole files, and what to know of their numbers.

    Raises
    ------
    SwarmError
        If the disk does not take them.
    """
    design, trial = arguments.design, arguments.trial
    contents = {
        TABLE: as_markdown(design, trial, len(arguments.seeds), summary, warning).encode(),
        CSV: as_csv(wanted, summary).encode(),
        FIGURE: study_figure(design, trial, summary),
    }
    write_files(arguments.out, contents)


def _print(arguments: Arguments, wanted: Sequence[Cell], summary: Summary, progress: str) -> None:
    """Print the numbers, how the targets stand, and where everything is."""
    console = console_on(sys.stdout)
    tables = (
        (CELL_HEADER, cell_rows(wanted, summary)),
        (TARGET_HEADER, target_rows(arguments.trial, summary)),
    )
    for header, rows in tables:
        if rows:
            table = Table(box=None, padding=(0, 2, 0, 0))
            for title in header:
                table.add_column(Text(title), no_wrap=True)
            for row in rows:
                table.add_row(*(Text(cell.replace("**", "")) for cell in row))
            console.print(table)
            console.print()
    if progress:
        console.print(progress, markup=False)
    console.print(f"results: {arguments.out / TABLE}, {CSV}, {FIGURE}", markup=False, soft_wrap=True)
