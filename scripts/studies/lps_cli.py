"""From the command line of ``lps_study.py`` to tables, a figure and an exit code."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from bringup.interruption import Interruption
from bringup.steady_stream import steady
from studies.campaign import ResultFile, completed
from studies.code_version import code_version
from studies.lps_arguments import Arguments, parse_arguments
from studies.lps_cells import Cell, Run, cells
from studies.lps_figure import study_figure
from studies.lps_runs import perform
from studies.lps_summary import Summary
from studies.lps_tables import CELL_HEADER, TARGET_HEADER, as_csv, as_markdown, cell_rows, target_rows
from swarm_msgs_py.errors import ConfigError, ShapeError, SwarmError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
RESULTS, TABLE, CSV, FIGURE = "results.jsonl", "table.md", "table.csv", "lps-study.png"
FILE_WIDTH = 140
PLAIN_S = 30.0  # between two lines where there is no terminal, wall time


def main(argv: Sequence[str] | None = None) -> int:
    """Run what is missing of the study, write what there is; return the exit code (0, 1, 2 or 130)."""
    with Interruption() as interruption:
        try:
            return _study(parse_arguments(sys.argv[1:] if argv is None else argv), interruption)
        except SwarmError as error:
            print(f"error: {' '.join(str(error).split())}", file=steady(sys.stderr))
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
    file = _open(arguments.out)
    warning = file.warning(run.key for run in runs)
    if warning:
        _console(sys.stderr).print(warning, markup=False, soft_wrap=True)
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
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    console, done, shown = _console(sys.stderr), len(runs) - len(missing), time.monotonic()
    with interruption.welcome(), Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as progress:
        bar = progress.add_task("runs", total=len(runs), completed=done)
        console.print(f"{done} of {len(runs)} runs are done, {workers} at a time")
        for run, scores in completed(missing, perform, workers):
            file.append(run.key, scores.as_record())
            done += 1
            progress.update(bar, completed=done, description=f"seed {run.seed}, {run.cell.mode.value}")
            if not console.is_terminal and time.monotonic() - shown >= PLAIN_S:
                shown = time.monotonic()
                console.print(f"{done} of {len(runs)} runs are done")


def _open(out: Path) -> ResultFile:
    """Return the file of results in a folder, which is made if it is missing.

    Raises
    ------
    ConfigError
        If the folder cannot be written to.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        if not os.access(out, os.W_OK):
            raise PermissionError(0, "no permission")
    except OSError as error:
        raise ConfigError(f"--out {out}: cannot be written ({error.strerror}); give another folder") from None
    return ResultFile(out / RESULTS, code_version())


def _write(arguments: Arguments, wanted: Sequence[Cell], summary: Summary, warning: str) -> None:
    """Write tables and figure; whoever looks sees whole files, and what to know of their numbers.

    Raises
    ------
    SwarmError
        If the disk does not take them.
    """
    design, trial = arguments.design, arguments.trial
    contents: dict[str, bytes | None] = {
        TABLE: as_markdown(design, trial, len(arguments.seeds), summary, warning).encode(),
        CSV: as_csv(wanted, summary).encode(),
        FIGURE: study_figure(design, trial, summary),
    }
    try:
        for name, data in contents.items():
            if data is not None:
                draft = arguments.out / f".{name}.part"
                draft.write_bytes(data)
                os.replace(draft, arguments.out / name)
    except OSError as error:
        raise SwarmError(f"{arguments.out}: tables could not be written ({error.strerror})") from None


def _print(arguments: Arguments, wanted: Sequence[Cell], summary: Summary, progress: str) -> None:
    """Print the numbers, how the targets stand, and where everything is."""
    console = _console(sys.stdout)
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


def _console(stream: TextIO) -> Console:
    """Return where to print; a file has room for a whole table."""
    return Console(file=steady(stream), width=None if stream.isatty() else FILE_WIDTH, highlight=False)
