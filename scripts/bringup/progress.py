"""What the operator sees while a run goes on: one live line, alerts above it, a summary at the end."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from bringup.engine import TickRecord
from bringup.results import FormationMetrics

REFRESH_S = 0.2  # of the live line, wall time
PLAIN_S = 5.0  # between two lines where there is no terminal, wall time


class Progress:
    """Shows a run; use as a context manager.

    Parameters
    ----------
    console : Console
        Where to; a live line on a terminal, now and then a plain line elsewhere.
    robots : int
        How many there are.
    """

    def __init__(self, console: Console, robots: int) -> None:
        self._console = console
        self._robots = robots
        self._live: Live | None = None
        self._began: float | None = None
        self._shown = -PLAIN_S
        self._alerts: list[str] = []
        self._place = "at their goals"

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

    def show(self, record: TickRecord, end: float, at_goal: int) -> None:
        """Take in one tick.

        Parameters
        ----------
        record : TickRecord
        end : float
            Simulated time at the end of the tick [s].
        at_goal : int
            Robots at their goals; where there are none, inside the shape.
        """
        now = time.monotonic()
        if self._began is None:
            self._began = now
        if record.plan is not None:
            self._place = "at their goals" if record.plan.task.has_goals else "inside the shape"
        for alert in record.alerts:
            self._alert(alert, record.truth.time)
        interval = REFRESH_S if self._live is not None else PLAIN_S
        if now - self._shown >= interval:
            self._shown = now
            line = self._line(end, now - self._began, at_goal, len(record.lost))
            if self._live is not None:
                self._live.update(line)
            else:
                self._console.print(line)

    def _alert(self, alert: str, at: float) -> None:
        """Print an alert; one that repeats tick after tick is printed once."""
        if alert not in self._alerts:
            self._alerts.append(alert)
            self._console.print(Text(f"{at:7.1f} s  ALERT  {alert}", style="bold red"), soft_wrap=True)

    def _line(self, end: float, wall: float, at_goal: int, lost: int) -> Text:
        factor = f"{end / wall:5.1f} x real time" if wall > REFRESH_S else "   -  x real time"
        line = Text(f"{end:7.1f} s  {factor}  {at_goal:3d} of {self._robots} robots {self._place}")
        if self._alerts:
            line.append(f"  {len(self._alerts)} alerts, {lost} lost", style="red")
        return line


def print_summary(console: Console, metrics: FormationMetrics, folder: str) -> None:
    """Print how a run ended and where its results are."""
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    for label, value in _rows(metrics):
        table.add_row(label, value)
    console.print(Text(metrics.reason, style="bold green" if metrics.achieved else "bold red"), soft_wrap=True)
    console.print(table)
    console.print(Text(f"results: {folder}"), soft_wrap=True)


def _rows(metrics: FormationMetrics) -> list[tuple[str, str]]:
    settled, bottleneck = _number(metrics.settling_time_s, "s"), _number(metrics.bottleneck_time_s, "s")
    displacement = _number(metrics.total_displacement_m, "m")
    if metrics.displacement_ratio is not None:
        ratio, bound = _number(metrics.displacement_ratio, "", 3), _number(metrics.displacement_lower_bound_m, "m")
        whose = "; of those that live " if metrics.lost_robots else " = "
        displacement += f"{whose}{ratio} x lower bound {bound}"
    traffic = f"{metrics.radio_bytes / 1e6:.2f} MB in {metrics.radio_frames} frames"
    rows = [
        ("settling time", f"{settled} (bottleneck {bottleneck})"),
        ("total displacement", displacement),
        ("collisions", f"{metrics.collisions} (least gap {_number(metrics.min_clearance_m, 'm', 3)})"),
        ("localization error", f"{_number(metrics.localization_rmse_m, 'm', 3)} rms"),
        ("radio", f"{traffic}, peak {metrics.radio_neighborhood_peak_bps / 1e3:.0f} kbit/s in a neighborhood"),
        ("speed", f"{_number(metrics.real_time_factor, 'x real time')}, start-up {_number(metrics.startup_s, 's')}"),
    ]
    if metrics.stage_settling_s is not None:
        rows.append(("stages settled", ", ".join(_number(each, "s") for each in metrics.stage_settling_s)))
    if metrics.morph_outside_fraction is not None:
        outside, recovery = 100.0 * metrics.morph_outside_fraction, _number(metrics.morph_recovery_s, "s")
        lag = _number(metrics.morph_latency_s, "s")
        rows.append(("moving shape", f"lag {lag}, {outside:.1f} % outside, recovered after {recovery}"))
    return rows


def _number(value: float | None, unit: str, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()
