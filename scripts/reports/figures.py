"""Figures of a run for papers and slides: the same bytes for the same run, fonts embedded, true sizes."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from reports import scene
from reports.palette import TYPE_COLORS
from reports.run_record import RunRecord
from reports.series import Chart, charts

WIDTH_IN, DPI = 12.0, 150
OVERVIEW_ASPECT, ARENA_ASPECT, CHART_ASPECT = 0.55, 1.05, 0.62  # height over width
CHART_COLUMNS, CHART_WIDTH_IN = 3, 2.5  # as many beside each other as can be read
FONT, LABEL, TITLE = scene.SMALL, 9, 11
SETTINGS: dict[Any, Any] = {"pdf.fonttype": 42, "ps.fonttype": 42, "svg.hashsalt": "swarm"}
"""TrueType fonts, as journals ask for; no random names in SVG files."""

UNDATED: Mapping[str, dict[str, str | None]] = {
    "png": {"Software": None},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None, "ModDate": None},
}
"""What would make two files of the same run differ."""


def figure_names(record: RunRecord) -> tuple[str, ...]:
    """Return the figures that can be made of a run."""
    return ("overview", "arena", "formation", "charts", *(chart.name for chart in charts(record)))


def make_figure(record: RunRecord, name: str, *, width_in: float | None = None, at_s: float | None = None) -> Figure:
    """Return a figure of a run.

    Parameters
    ----------
    record : RunRecord
    name : str
        One of `figure_names`.
    width_in : float or None
        Its width [in]; the height follows.
    at_s : float or None
        Time that pictures of the arena show [s]; None for the end.
    """
    edge = _edge_at(record, at_s)
    pictures: dict[str, Callable[[], Figure]] = {
        "overview": lambda: _overview(record, width_in or WIDTH_IN, edge),
        "arena": lambda: _single(record, width_in or WIDTH_IN / 2.0, edge, _draw_arena),
        "formation": lambda: _single(record, width_in or WIDTH_IN / 2.0, edge, _draw_formation),
        "charts": lambda: _chart_grid(charts(record), width_in or WIDTH_IN),
    }
    if name in pictures:
        return pictures[name]()
    chart = next(chart for chart in charts(record) if chart.name == name)
    return _chart_grid((chart,), width_in or WIDTH_IN / CHART_COLUMNS)


def encoded(figure: Figure, kind: str, dpi: int = DPI) -> bytes:
    """Return a figure as a ``png``, ``svg`` or ``pdf`` file."""
    buffer = io.BytesIO()
    with mpl.rc_context(SETTINGS):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=UNDATED[kind])
    return buffer.getvalue()


def headline(record: RunRecord) -> str:
    """Return what came out of a run, in a line."""
    metrics = record.metrics
    outcome = "achieved" if metrics.get("achieved") else "not achieved"
    named = ", ".join(str(metrics[key]) for key in ("scenario", "method") if metrics.get(key))
    parts = [f"{named}, seed {metrics.get('seed')}: {outcome}", f"{len(record.robots)} robots"]
    if metrics.get("settling_time_s") is not None:
        parts.append(f"settled after {metrics['settling_time_s']:.1f} s")
    if metrics.get("total_displacement_m") is not None:
        parts.append(f"total displacement {metrics['total_displacement_m']:.0f} m")
    if metrics.get("displacement_ratio") is not None:
        parts.append(f"{metrics['displacement_ratio']:.2f} x lower bound")
    return "  |  ".join(parts)


def blank(width_in: float, aspect: float) -> Figure:
    """Return an empty figure of a width [in] and a height over width, with a canvas of its own."""
    figure = Figure(figsize=(width_in, aspect * width_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _edge_at(record: RunRecord, at_s: float | None) -> int:
    last = max(len(record.edge_times) - 1, 0)
    if at_s is None:
        return last
    return int(np.clip(np.searchsorted(record.edge_times, at_s, side="right") - 1, 0, last))


def _overview(record: RunRecord, width_in: float, edge: int) -> Figure:
    """Return the whole arena with all trajectories on the left, the formation on the right.

    Circles have their true size, both panels equal axes.
    """
    figure = blank(width_in, OVERVIEW_ASPECT)
    arena, detail = figure.subplots(1, 2)
    has_earlier = _draw_arena(arena, record, edge)
    if record.arrays["position"].shape[-1] == 3:
        _draw_side(detail, record, edge)
    else:
        _draw_formation(detail, record, edge)
    figure.suptitle(headline(record), fontsize=TITLE)
    handles = scene.legend_handles(record, has_earlier_shapes=has_earlier)
    figure.legend(handles=handles, loc="outside lower center", ncols=8, fontsize=FONT, frameon=False)
    return figure


def _single(record: RunRecord, width_in: float, edge: int, draw: Callable[[Axes, RunRecord, int], bool]) -> Figure:
    figure = blank(width_in, ARENA_ASPECT)
    has_earlier = draw(figure.subplots(), record, edge)
    handles = scene.legend_handles(record, has_earlier_shapes=has_earlier)
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=FONT, frameon=False)
    return figure


def _draw_arena(axes: Axes, record: RunRecord, edge: int) -> bool:
    has_earlier = _draw_swarm(axes, record, edge)
    _label(axes, "arena and trajectories")
    if len(record.arrays["position"]):
        scene.frame_arena(axes, record)
    return has_earlier


def _draw_formation(axes: Axes, record: RunRecord, edge: int) -> bool:
    has_earlier = _draw_swarm(axes, record, edge)
    if len(record.arrays["position"]):
        scene.GoalMarks(axes, record).put(edge)
    _label(axes, "final formation" if edge == len(record.edge_times) - 1 else "formation")
    contour = record.point_sets("shape").at(edge)
    if len(contour):
        scene.frame_points(axes, contour)
    elif record.ticks:
        scene.frame_points(axes, record.edge_positions[edge][:, :2])
    return has_earlier


def _draw_side(axes: Axes, record: RunRecord, edge: int) -> None:
    plane = (0, 2)
    _label(axes, "from the side", "z [m]")
    if not record.ticks:
        return
    scene.draw_surface(axes, record, edge, plane)
    scene.draw_trajectories(axes, record, plane)
    scene.RobotMarks(axes, record, plane).put(edge)
    scene.frame_arena(axes, record, plane)


def _draw_swarm(axes: Axes, record: RunRecord, edge: int) -> bool:
    scene.draw_ground(axes, record)
    contour = record.point_sets("shape").at(edge)
    if len(contour):
        scene.draw_shape(axes, contour)
    has_earlier = scene.draw_earlier_shapes(axes, record)
    if record.ticks:
        scene.draw_surface(axes, record, edge)
        scene.draw_trajectories(axes, record)
        scene.RobotMarks(axes, record).put(edge)
    return has_earlier


def _label(axes: Axes, title: str, vertical: str = "y [m]") -> None:
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]", fontsize=LABEL)
    axes.set_ylabel(vertical, fontsize=LABEL)
    axes.tick_params(labelsize=FONT)
    axes.set_title(title, fontsize=LABEL + 1)


def _chart_grid(shown: tuple[Chart, ...], width_in: float) -> Figure:
    columns = min(max(int(width_in / CHART_WIDTH_IN), 1), CHART_COLUMNS, max(len(shown), 1))
    rows = max(math.ceil(len(shown) / columns), 1)
    figure = blank(width_in, CHART_ASPECT * rows / columns)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, chart in zip(panels, shown, strict=False):
        for line, color in zip(chart.lines, TYPE_COLORS * len(chart.lines), strict=False):
            axes.plot(chart.times, line.values, color=color, linewidth=1.1, label=line.label)
        axes.set_title(chart.title, fontsize=LABEL)
        axes.set_xlabel("time [s]", fontsize=FONT + 0.5)
        axes.set_ylabel(chart.unit, fontsize=FONT + 0.5)
        axes.tick_params(labelsize=FONT)
        axes.grid(visible=True, linewidth=0.3)
        axes.margins(x=0.0)
        if len(chart.lines) > 1:
            axes.legend(fontsize=FONT - 1.0, frameon=False)
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    return figure
