"""From the command line of ``monte_carlo.py`` to tables, a figure and an exit code."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from contextlib import ExitStack

from rich.table import Table
from rich.text import Text

from batches.arguments import Arguments, parse_arguments
from batches.cells import Cell, Run, cells, runs
from batches.cluster import Cluster
from batches.comparison import Comparison
from batches.comparison_figure import comparison_figure
from batches.folder_cells import folder_cells, store_cells
from batches.performing import Performed, perform
from batches.runs_table import runs_parquet
from batches.tables import NAMING, SHORT_HEADER, as_csv, as_markdown, short_rows
from bringup.installation import check_physics
from bringup.interruption import Interruption
from bringup.option_types import complain
from bringup.resolution import resolve
from bringup.steady_stream import steady
from studies.campaign import Record, ResultFile, completed
from studies.campaign_folder import locked, open_results, read_results, write_files
from studies.campaign_progress import console_on, follow
from swarm_msgs_py.errors import ConfigError, PhysicsError, ShapeError, SwarmError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
RUNS, SUMMARY, CSV, FIGURE = "runs.parquet", "summary.md", "summary.csv", "comparison.png"


def main(argv: Sequence[str] | None = None) -> int:
    """Run what is missing of the batch, write what there is; return the exit code (0, 1, 2 or 130)."""
    with Interruption() as interruption:
        try:
            return _batch(parse_arguments(sys.argv[1:] if argv is None else argv), interruption)
        except SwarmError as error:
            complain(error)
            return BAD_INPUT if isinstance(error, ConfigError | ShapeError | PhysicsError) else FAILED
        except KeyboardInterrupt:
            print("interrupted before the start; nothing was written", file=steady(sys.stderr))
            return INTERRUPTED


def _batch(arguments: Arguments, interruption: Interruption) -> int:
    """Check, simulate and write.

    Raises
    ------
    SwarmError
        If the input is bad, or a worker or the cluster failed; what was done is in the file of results then.
    """
    with interruption.welcome():
        wanted = cells(arguments.design)
        every = list(runs(wanted, arguments.design.seeds))
        counted = _counted(read_results(arguments.out), arguments)
        folder_cells(arguments.out, wanted, counted)
        if arguments.simulates:
            _check(every, counted)
    with ExitStack() as stack:
        cluster = None
        if arguments.simulates and arguments.scheduler is not None:
            with interruption.welcome():
                cluster = stack.enter_context(Cluster(arguments.scheduler))
        if arguments.simulates:
            open_results(arguments.out)
            stack.enter_context(locked(arguments.out))
        file = open_results(arguments.out)  # what another batch wrote until it let go of the lock is in it
        try:
            if arguments.simulates:
                store_cells(arguments.out, wanted)
                _simulate(arguments, cluster, every, file, interruption)
        except KeyboardInterrupt:
            pass
        finally:  # also when a worker died: who looks into the folder finds tables of all that is there
            comparison, notes = _write(arguments, wanted, every, file)
    _print(arguments, comparison, notes)
    return INTERRUPTED if interruption.requested else DONE


def _counted(file: ResultFile, arguments: Arguments) -> Mapping[str, Record]:
    """Return the results that count: unless the operator wants it, those of other code do not."""
    if arguments.keeps_outdated:
        return file.records
    outdated = file.outdated
    return {key: record for key, record in file.records.items() if key not in outdated}


def _check(every: Sequence[Run], counted: Mapping[str, Record]) -> None:
    """Refuse cells of which no run could be made, before anything is written; cells with results have been checked.

    Raises
    ------
    ConfigError
    """
    known = {run.cell.key for run in every if run.key in counted}
    for run in {run.cell.key: run for run in reversed(every)}.values():  # the first of each cell
        if run.cell.key not in known:
            check_physics(resolve(run.scenario, run.cell.origin))


def _simulate(
    arguments: Arguments, cluster: Cluster | None, every: Sequence[Run], file: ResultFile, interruption: Interruption
) -> None:
    """Run what is missing.

    Raises
    ------
    SwarmError
        If a worker, the cluster or the disk failed.
    KeyboardInterrupt
        At an interruption.
    """
    counted, workers = _counted(file, arguments), arguments.workers
    missing = [run for run in every if run.key not in counted]
    if not missing:
        return

    def keep(run: Run, performed: Performed) -> None:
        file.append(run.key, performed.as_record())

    try:
        follow(
            completed(missing, perform, workers) if cluster is None else cluster.completed(missing),
            keep,
            done=len(every) - len(missing),
            total=len(every),
            where=f"{workers} at a time"
            if cluster is None
            else f"{cluster.threads or 'no worker yet'} at a time on the cluster",
            label=lambda run: f"{run.cell.place[1]}, {run.cell.variant}, seed {run.seed}",
            interruption=interruption,
        )
    except OSError as error:
        raise SwarmError(f"{file.path}: cannot be written ({error.strerror}); what it has is kept") from None


def _write(
    arguments: Arguments, wanted: Sequence[Cell], every: Sequence[Run], file: ResultFile
) -> tuple[Comparison, list[str]]:
    """Write table, summary and figure of all that the folder has; return the comparison, and what to know of it.

    A command with fewer cells or other seeds than an earlier one of the same folder takes nothing out of the tables.

    Raises
    ------
    SwarmError
        If the disk does not take them.
    """
    counted = _counted(file, arguments)
    cells_, unknown = folder_cells(arguments.out, wanted, counted)
    comparison = Comparison(cells_, counted)
    left = sum(run.key not in counted for run in every)
    old = len(file.records) - len(counted)
    asked = {run.key for run in every}
    others = sum(run.key not in asked for run in comparison.runs)
    unlike = comparison.unlike_starts()
    notes = [
        f"{len(every) - left} of {len(every)} runs are done; the same command goes on with the rest" if left else "",
        f"{others} more runs are of earlier commands with this folder" if others else "",
        f"{old} results of other code are left out; runs that are asked for again are made anew, or give "
        "--keep-outdated"
        if old
        else "",
        f"warning: results of {unknown} combinations are left out: nothing that this code can read says what they are"
        if unknown
        else "",
        file.warning(run.key for run in comparison.runs),
        f"warning: {unlike} pairs of runs did not start alike; they count in no difference" if unlike else "",
    ]
    notes = [note for note in notes if note]
    if comparison.places:
        contents = {
            RUNS: runs_parquet(comparison.runs, file.records, file.versions),
            SUMMARY: as_markdown(comparison, notes).encode(),
            CSV: as_csv(comparison).encode(),
            FIGURE: comparison_figure(comparison),
        }
        write_files(arguments.out, contents)
    return comparison, notes


def _print(arguments: Arguments, comparison: Comparison, notes: Sequence[str]) -> None:
    """Print the means, what to know of them, and where everything is."""
    console = console_on(sys.stdout)
    if comparison.places:
        table = Table(box=None, padding=(0, 2, 0, 0))
        for title in SHORT_HEADER:
            table.add_column(Text(title), no_wrap=title in NAMING)  # on a narrow terminal, titles of numbers wrap
        for row in short_rows(comparison):
            table.add_row(*map(Text, row))
        console.print(table)
    for note in notes:
        console.print(note, markup=False, soft_wrap=True)
    if comparison.places:
        where = f"{arguments.out / SUMMARY}, {CSV}, {RUNS}, {FIGURE}"
        console.print(f"results: {where}", markup=False, soft_wrap=True)
