"""The picture of the tracking study: where boats went, and how far off they were."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from studies.tracking_curves import CurveKind
from studies.tracking_tables import LABELS
from studies.tracking_trial import Track
from swarm_sim.boats.config import ControllerKind

COLORS = {
    ControllerKind.LADRC: "#0072b2",
    ControllerKind.LADRC_PAPER: "#56b4e9",
    ControllerKind.PID: "#e69f00",
    ControllerKind.PID_ZN: "#d55e00",
}
"""Of the Okabe-Ito palette, which color-blind readers can tell apart."""
WIDTH_IN, ROW_IN, DPI = 13.0, 4.2, 150

Tracks = Mapping[tuple[CurveKind, ControllerKind], Track]


def tracking_figure(tracks: Tracks, seeds: int) -> bytes:
    """Return the PNG: a row per curve with the paths of the first seed, position errors and heading errors."""
    curves = list(dict.fromkeys(curve for curve, _ in tracks))
    figure = Figure(figsize=(WIDTH_IN, ROW_IN * len(curves)), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(curves), 3, squeeze=False)
    for (paths, positions, headings), curve in zip(panels, curves, strict=True):
        mine = {controller: track for (kind, controller), track in tracks.items() if kind is curve}
        _draw_paths(paths, curve, mine)
        _draw_errors(positions, mine, "position error [m]", is_heading=False)
        _draw_errors(headings, mine, "heading error [deg]", is_heading=True)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=9, frameon=False)
    figure.suptitle(f"One boat under wind and waves; errors: mean of {seeds} seeds, paths: the first", fontsize=11)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw_paths(axes: Axes, curve: CurveKind, tracks: Mapping[ControllerKind, Track]) -> None:
    wanted = next(iter(tracks.values())).wanted
    axes.plot(wanted[:, 0], wanted[:, 1], color="0.7", linewidth=4.0, label="wanted")
    for controller, track in tracks.items():
        axes.plot(
            track.poses[:, 0, 0],
            track.poses[:, 0, 1],
            color=COLORS[controller],
            linewidth=1.0,
            label=LABELS[controller],
        )
    axes.set_aspect("equal")
    axes.set_title(curve.value, fontsize=10)
    axes.set_xlabel("x [m]", fontsize=9)
    axes.set_ylabel("y [m]", fontsize=9)


def _draw_errors(axes: Axes, tracks: Mapping[ControllerKind, Track], label: str, *, is_heading: bool) -> None:
    for controller, track in tracks.items():
        errors = np.degrees(track.heading_errors) if is_heading else track.position_errors
        axes.semilogy(track.times, errors.mean(axis=1), color=COLORS[controller], linewidth=0.9)
    axes.set_xlabel("time [s]", fontsize=9)
    axes.set_ylabel(label, fontsize=9)
    axes.grid(visible=True, color="0.9")
