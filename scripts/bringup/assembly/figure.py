"""The picture of an assembly run: who went where, and what stands."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.transforms import Affine2D

from bringup.family import Metrics
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import CELL_M

TARGET, WAY, HULL, DEAD, DOCK = "#E8E2D0", "#56B4E9", "#0072B2", "#999999", "#D55E00"
SIZE_IN, DPI = 7.5, 130


def run_figure(arrays: Mapping[str, np.ndarray], metrics: Metrics, side_m: float) -> bytes:
    """Return the PNG of a run: targets, ways of the boats, hulls and docks at the end.

    Parameters
    ----------
    arrays : mapping
        As ``trajectories.npz`` holds them.
    metrics : Metrics
    side_m : float
        Edge of a hull [m].
    """
    figure = Figure(figsize=(SIZE_IN, SIZE_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for cell in arrays["targets"]:
        corner = CELL_M * (cell - 0.5)
        axes.add_patch(Rectangle((corner[0], corner[1]), CELL_M, CELL_M, facecolor=TARGET, edgecolor="none", zorder=0))
    positions = arrays["position"]
    if len(positions):
        for boat in range(positions.shape[1]):
            axes.plot(*positions[:, boat].T, "-", color=WAY, linewidth=0.7, zorder=1)
            _draw_hull(axes, positions[-1, boat], arrays["yaw"][-1, boat], side_m, alive=arrays["alive"][-1, boat])
        for one, other in arrays["latches"]:
            axes.plot(*positions[-1, [one, other]].T, "-", color=DOCK, linewidth=2.0, zorder=4)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_xlabel("x [m]", fontsize=9)
    axes.set_ylabel("y [m]", fontsize=9)
    values = metrics.values
    outcome = "achieved" if metrics.achieved else "not achieved"
    axes.set_title(
        f"{values['scenario']}, seed {values['seed']}: {outcome}  |  {values['filled_places']} of {values['places']}"
        f" places  |  {values['docked_edges']} docks  |  {values['sim_time_s']:.0f} s",
        fontsize=10,
    )
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw_hull(axes: Axes, position: FloatArray, yaw: float, side_m: float, *, alive: bool) -> None:
    turn = Affine2D().rotate_around(position[0], position[1], yaw) + axes.transData
    corner = position - 0.5 * side_m
    color = HULL if alive else DEAD
    axes.add_patch(
        Rectangle((corner[0], corner[1]), side_m, side_m, facecolor=color, alpha=0.55, transform=turn, zorder=3)
    )
    axes.plot(*position, ".", color=color, markersize=2, zorder=3)
