"""How far a campaign is: a live line with rate and remaining time, plain lines where nobody watches."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from typing import TextIO, TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from bringup.interruption import Interruption
from bringup.steady_stream import steady

FILE_WIDTH = 140
PLAIN_S = 30.0  # between two lines where there is no terminal, wall time
RATE_PERIOD_S = 600.0  # rate and remaining time are means over this long: runs take seconds to minutes
MINUTE_S = 60.0
RunT = TypeVar("RunT")
ResultT = TypeVar("ResultT")


class RateColumn(ProgressColumn):
    """Runs per minute of wall time."""

    def render(self, task: Task) -> Text:
        """Return the rate, or nothing as long as there is none."""
        return Text(f"{MINUTE_S * task.speed:.1f} runs/min" if task.speed else "")


def console_on(stream: TextIO) -> Console:
    """Return where to print; a file has room for a whole table."""
    return Console(file=steady(stream), width=None if stream.isatty() else FILE_WIDTH, highlight=False)


def follow(  # noqa: PLR0913 - what comes, what to do with it, and what to say
    results: Iterable[tuple[RunT, ResultT]],
    keep: Callable[[RunT, ResultT], None],
    *,
    done: int,
    total: int,
    where: str,
    label: Callable[[RunT], str],
    interruption: Interruption,
) -> None:
    """Keep results as they come, and show how far the campaign is on standard error.

    Parameters
    ----------
    results : iterable of (run, result)
    keep : callable
        What to do with each.
    done, total : int
        Runs that have results already, and all.
    where : str
        How the runs are worked off, for people.
    label : callable
        What to call a run.
    interruption : Interruption

    Raises
    ------
    KeyboardInterrupt
        At an interruption; what came before is kept.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), RateColumn(), TimeElapsedColumn())
    console, shown = console_on(sys.stderr), time.monotonic()
    remaining = TimeRemainingColumn()
    progress = Progress(*columns, remaining, console=console, transient=True, speed_estimate_period=RATE_PERIOD_S)
    with interruption.welcome(), progress:
        bar = progress.add_task("runs", total=total, completed=done)
        console.print(f"{done} of {total} runs are done, {where}", markup=False)
        for run, result in results:
            keep(run, result)
            done += 1
            progress.update(bar, completed=done, description=label(run))
            if not console.is_terminal and time.monotonic() - shown >= PLAIN_S:
                shown = time.monotonic()
                console.print(f"{done} of {total} runs are done")
