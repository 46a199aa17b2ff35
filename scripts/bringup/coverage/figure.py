"""The picture of a coverage run: who went where, and what is covered."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from bringup.family import Metrics
from swarm_msgs_py.types import FloatArray, NodeId

VIEWS = ((0, 1), (0, 2), (1, 2))
AXES = "xyz"
SHAPE, WAY, PLACE, LINK, LEADER = "#C9BFA6", "#56B4E9", "#0072B2", "#009E73", "#D55E00"
WIDTH_IN, HEIGHT_IN, DPI = 13.0, 4.8, 130


def run_figure(
    arrays: Mapping[str, np.ndarray], holders: Sequence[NodeId], surface: FloatArray, metrics: Metrics
) -> bytes:
    """Return the PNG of a run: three views of the shape, the ways of the robots, their places and links.

    Parameters
    ----------
    arrays : mapping
        As ``trajectories.npz`` holds them.
    holders : sequence of NodeId
        Who holds a place at the end.
    surface : (k, 3) array
        Points on the surface of the shape [m].
    metrics : Metrics
    """
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    positions = arrays["position"]
    for axes, view in zip(figure.subplots(1, len(VIEWS)), VIEWS, strict=True):
        axes.plot(*surface[:, view].T, ".", color=SHAPE, markersize=1.0, zorder=0)
        if len(positions):
            _draw_robots(axes, positions, list(holders), view, float(metrics.values["link_m"]))
        axes.set_aspect("equal")
        axes.set_xlabel(f"{AXES[view[0]]} [m]", fontsize=9)
        axes.set_ylabel(f"{AXES[view[1]]} [m]", fontsize=9)
        axes.tick_params(labelsize=7.5)
    values = metrics.values
    outcome = "achieved" if metrics.achieved else "not achieved"
    covered = "-" if values["covered_fraction"] is None else f"{values['covered_fraction']:.5f}"
    figure.suptitle(
        f"{values['scenario']}, {values['method']}, seed {values['seed']}: {outcome}  |  "
        f"{values['placed_robots']} robots at places  |  covered {covered}  |  "
        f"expansion {values['expansion_time_s']:.0f} s",
        fontsize=11,
    )
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw_robots(axes: Axes, positions: FloatArray, holders: list[int], view: tuple[int, int], link: float) -> None:
    """Draw ways, links and places, seen along one axis."""
    for robot in holders:
        axes.plot(*positions[:, robot, view].T, "-", color=WAY, linewidth=0.6, alpha=0.7)
    places = positions[-1, holders]
    if len(places) > 1:
        for first, second in cKDTree(places).query_pairs(link):
            axes.plot(*places[[first, second]][:, view].T, "-", color=LINK, linewidth=0.8)
    axes.plot(*places[:, view].T, "o", color=PLACE, markersize=4)
    axes.plot(*positions[-1, :1, view].reshape(2, 1), "s", color=LEADER, markersize=5)
