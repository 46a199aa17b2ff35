"""What the operator sees while a run goes on: one live line, alerts above it, a summary at the end."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Any, Protocol

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from bringup.dashboard import Dashboard
from bringup.engine import TickRecord
from bringup.family import Metrics
from swarm_msgs_py.errors import SwarmError

REFRESH_S = 0.2  # of the live line, wall time
PLAIN_S = 5.0  # between two lines where there is no terminal, wall time


class Onlooker(Protocol):
    """Whoever else is to see a run while it goes on."""

    def take(self, record: TickRecord[Any, Any]) -> None:
        """Take in one tick.

        Raises
        ------
        SwarmError
            If it cannot; the operator is told in a line, and the run goes on without it.
        """
        ...


class Progress:
    """Shows a run; use as a context manager.

    Parameters
    ----------
    console : Console
        Where to; a live line on a terminal, now and then a plain line elsewhere.
    dashboard : Dashboard or None
        Shows every robot below the live line; on a terminal only.
    live : Onlooker or None
        Is shown every tick.
    """

    def __init__(self, console: Console, dashboard: Dashboard | None = None, live: Onlooker | None = None) -> None:
        self._console = console
        self._dashboard = dashboard
        self._onlooker = live
        self._live: Live | None = None
        self._began: float | None = None
        self._shown = -PLAIN_S
        self._alerts: list[str] = []

    def __enter__(self) -> Progress:
        """Begin the live line."""
        if self._console.is_terminal:
            self._live = Live(console=self._console, refresh_per_second=1.0 / REFRESH_S, transient=True)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take the live line away."""
        if self._live is not None:
            self._live.stop()
            self._live = None

    def say(self, line: str) -> None:
        """Print one line of its own."""
        self._console.print(Text(line), soft_wrap=True)

    def show(self, record: TickRecord[Any, Any], end: float, status: str) -> None:
        """Take in one tick.

        Parameters
        ----------
        record : TickRecord
        end : float
            Simulated time at the end of the tick [s].
        status : str
            How far the swarm is.
        """
        now = time.monotonic()
        if self._began is None:
            self._began = now
        for alert in record.alerts:
            self._alert(alert, record.truth.time)
        if self._dashboard is not None:
            self._dashboard.take(record)
        self._show_onlooker(record)
        interval = REFRESH_S if self._live is not None else PLAIN_S
        if now - self._shown >= interval:
            self._shown = now
            line = self._line(end, now - self._began, status, len(record.lost))
            if self._live is not None:
                board = self._dashboard
                self._live.update(line if board is None else board.render(line, self._console.height))
            else:
                self._console.print(line)

    def _show_onlooker(self, record: TickRecord[Any, Any]) -> None:
        if self._onlooker is None:
            return
        try:
            self._onlooker.take(record)
        except SwarmError as error:
            self._onlooker = None
            self._alert(f"{error}; the run goes on without", record.truth.time)

    def _alert(self, alert: str, at: float) -> None:
        """Print an alert; one that repeats tick after tick is printed once."""
        if alert not in self._alerts:
            self._alerts.append(alert)
            self._console.print(Text(f"{at:7.1f} s  ALERT  {alert}", style="bold red"), soft_wrap=True)

    def _line(self, end: float, wall: float, status: str, lost: int) -> Text:
        factor = f"{end / wall:5.1f} x real time" if wall > REFRESH_S else "   -  x real time"
        line = Text(f"{end:7.1f} s  {factor}  {status}")
        if self._alerts:
            line.append(f"  {len(self._alerts)} alerts, {lost} lost", style="red")
        return line


def print_summary(console: Console, metrics: Metrics, folder: str) -> None:
    """Print how a run ended and where its results are."""
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    for label, value in metrics.rows:
        table.add_row(label, value)
    console.print(Text(metrics.reason, style="bold green" if metrics.achieved else "bold red"), soft_wrap=True)
    console.print(table)
    console.print(Text(f"results: {folder} (look at report.html)"), soft_wrap=True)
