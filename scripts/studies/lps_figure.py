"""The picture of the study: error against localization period, beacon share and noise."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from studies.lps_cells import (
    BASE_SHARE,
    BASE_SIGMA_M,
    CONTROL_RATE,
    Cell,
    Design,
    Motion,
    Sweep,
    SweepKind,
    Trial,
    sweeps,
)
from studies.lps_summary import THESIS, Summary
from studies.lps_tables import MODE_LABELS, period_label
from swarm_agent.localization.config import LpsMode

COLORS = {
    LpsMode.LITERAL: "#555555",
    LpsMode.FIXES: "#d55e00",
    LpsMode.RANGE_EKF: "#e69f00",
    LpsMode.COOPERATIVE: "#0072b2",
}
"""Of the Okabe-Ito palette, which color-blind readers can tell apart."""

MARKERS = {LpsMode.LITERAL: "s", LpsMode.FIXES: "^", LpsMode.RANGE_EKF: "D", LpsMode.COOPERATIVE: "o"}
CLAIM = "#cc79a7"
WIDTH_IN, HEIGHT_IN, DPI = 13.0, 4.9, 160
CONTROL_RATE_AT_S = 0.5
"""Where the control rate is drawn: at the control period of the reference setting."""


def study_figure(design: Design, trial: Trial, summary: Summary) -> bytes | None:
    """Return the PNG with one panel per sweep that has results; None without any."""
    shown = [sweep for sweep in sweeps(design) if any(cell in summary for cell in sweep.cells)]
    if not shown:
        return None
    figure = Figure(figsize=(WIDTH_IN * max(len(shown), 2) / 3.0, HEIGHT_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(shown), squeeze=False)[0]
    draw: dict[SweepKind, Callable[[Axes, Sweep, Summary], None]] = {
        SweepKind.PERIOD: _draw_periods,
        SweepKind.SHARE: _draw_shares,
        SweepKind.NOISE: _draw_noises,
    }
    for panel, sweep in zip(panels, shown, strict=True):
        draw[sweep.kind](panel, sweep, summary)
        panel.set_ylabel("position error [m]", fontsize=10)
        panel.tick_params(labelsize=9)
        panel.grid(visible=True, which="major", color="0.9")
        panel.set_axisbelow(True)
    seeds = max(summary.seeds(cell) for sweep in shown for cell in sweep.cells)
    motion = {Motion.REST: "at rest", Motion.PARKED: "parked", Motion.WANDER: "wandering"}[design.motion]
    span = f"{trial.warm_up_s:g} to {trial.duration_s:g} s, up to {seeds} seeds; bars: best to worst seed"
    figure.suptitle(f"{trial.robots} robots {motion} in a shape, errors of the non-beacons, {span}", fontsize=11)
    handles = _legend(design, shown)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=9, frameon=False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw_periods(axes: Axes, sweep: Sweep, summary: Summary) -> None:
    """Draw rms (solid) and largest error (dotted) on a logarithmic axis, with what the thesis claims."""
    periods = sorted({cell.period_s for cell in sweep.cells if cell in summary})
    for mode in _modes(sweep, summary):
        own = [cell for cell in sweep.cells if cell.mode is mode]
        places = [cell.period_s or CONTROL_RATE_AT_S for cell in own]
        _draw_line(axes, own, places, "rms_m", summary)
        _draw_line(axes, own, places, "max_m", summary, style=":")
    claims = [(point.period_s, point.claimed_max_m) for point in THESIS if point.period_s in periods]
    axes.plot([x for x, _ in claims], [y for _, y in claims], "*", markersize=13, color=CLAIM)
    axes.set_yscale("log")
    ticks = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0]
    axes.set_yticks(ticks, labels=[f"{tick:g}" for tick in ticks], minor=False)
    axes.set_yticks([], minor=True)
    axes.set_xticks(
        [period or CONTROL_RATE_AT_S for period in periods],
        labels=[period_label(period).replace(" rate", "\nrate") for period in periods],
    )
    axes.set_xlabel("localization period", fontsize=10)
    axes.set_title(f"period ({BASE_SHARE:.0%} beacons, noise {BASE_SIGMA_M:g} m)", fontsize=10)


def _draw_shares(axes: Axes, sweep: Sweep, summary: Summary) -> None:
    _draw_variants(axes, sweep, summary, lambda cell: 100.0 * cell.share)
    axes.set_xlabel("robots that are beacons [%]", fontsize=10)
    axes.set_title(f"beacon share (rms, noise {BASE_SIGMA_M:g} m)", fontsize=10)


def _draw_noises(axes: Axes, sweep: Sweep, summary: Summary) -> None:
    _draw_variants(axes, sweep, summary, lambda cell: cell.sigma_m)
    axes.set_xlabel("noise of a range (literal: of a position) [m]", fontsize=10)
    axes.set_title(f"noise (rms, {BASE_SHARE:.0%} beacons)", fontsize=10)


def _draw_variants(axes: Axes, sweep: Sweep, summary: Summary, place: Callable[[Cell], float]) -> None:
    """Draw the rms of each mode and period: solid at the base period, dashed at the control rate."""
    for mode in _modes(sweep, summary):
        for period in sorted({cell.period_s for cell in sweep.cells if cell.mode is mode}):
            own = [cell for cell in sweep.cells if cell.mode is mode and cell.period_s == period]
            style = "--" if period == CONTROL_RATE else "-"
            _draw_line(axes, own, [place(cell) for cell in own], "rms_m", summary, style)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)


def _draw_line(  # noqa: PLR0913, PLR0917 - what, where and how
    axes: Axes, cells: Sequence[Cell], places: Sequence[float], name: str, summary: Summary, style: str = "-"
) -> None:
    """Draw the mean over the seeds, with bars from the best seed to the worst."""
    found = [(x, cell, s) for x, cell in zip(places, cells, strict=True) if (s := summary.statistic(cell, name))]
    if not found:
        return
    mode = found[0][1].mode
    mean = [statistic.mean for _, _, statistic in found]
    below = [statistic.mean - statistic.best for _, _, statistic in found]
    above = [statistic.worst - statistic.mean for _, _, statistic in found]
    axes.errorbar(
        [x for x, _, _ in found],
        mean,
        yerr=[below, above],
        linestyle=style,
        marker=MARKERS[mode],
        color=COLORS[mode],
        markersize=5,
        linewidth=1.5,
        elinewidth=0.8,
        capsize=2.5,
        markerfacecolor=COLORS[mode] if style == "-" else "white",
    )


def _modes(sweep: Sweep, summary: Summary) -> list[LpsMode]:
    return list(dict.fromkeys(cell.mode for cell in sweep.cells if cell in summary))


def _legend(design: Design, shown: Sequence[Sweep]) -> list[Line2D]:
    modes = [mode for mode in LpsMode if mode in design.modes]
    handles = [
        Line2D([], [], color=COLORS[mode], marker=MARKERS[mode], linewidth=1.5, label=MODE_LABELS[mode])
        for mode in modes
    ]
    kinds = {sweep.kind for sweep in shown}
    if SweepKind.PERIOD in kinds:
        handles.append(Line2D([], [], color="0.3", linestyle=":", label="largest error"))
        handles.append(Line2D([], [], color=CLAIM, marker="*", linestyle="", markersize=12, label="largest, thesis"))
    if kinds - {SweepKind.PERIOD}:
        handles.append(Line2D([], [], color="0.3", linestyle="-", label="every 3 s"))
        if LpsMode.COOPERATIVE in modes:
            handles.append(Line2D([], [], color="0.3", linestyle="--", label="control rate"))
    return handles
