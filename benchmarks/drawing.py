"""How the benchmarks draw: panels of points with their mean, and targets as dashed lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

BLUE, VERMILION, GRAY = "#0072B2", "#D55E00", "#555555"  # of the Okabe-Ito palette: safe for color blindness
PANEL_IN, HEIGHT_IN, DPI = 4.5, 3.9, 150
SPREAD = 0.28  # of the points of a group, sideways, as a share of the distance between two groups
TARGET = {"color": GRAY, "ls": "--", "lw": 1.0}


def panels(count: int, width_in: float = PANEL_IN) -> tuple[Figure, list[Axes]]:
    """Return a figure with `count` panels side by side, each `width_in` inches wide."""
    figure = Figure(figsize=(width_in * count, HEIGHT_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = list(figure.subplots(1, count, squeeze=False)[0])
    for one in axes:
        one.grid(axis="y", color="#DDDDDD", lw=0.6)
        one.set_axisbelow(True)
        one.spines[["top", "right"]].set_visible(False)
        one.tick_params(labelsize=8)
    return figure, axes


def draw_groups(
    axes: Axes, title: str, groups: Mapping[str, Sequence[float]], targets: Mapping[str, float | None]
) -> None:
    """Draw each group's values as points in a column, its mean as a bar, and its target as a dashed line.

    Parameters
    ----------
    axes : Axes
    title : str
        What is shown, with its unit.
    groups : mapping of str to sequence of float
        Values of each group, by its name; empty ones leave a gap.
    targets : mapping of str to float or None
        What at most is aimed at, by the name of the group.
    """
    for place, (name, values) in enumerate(groups.items()):
        target = targets.get(name)
        if target is not None:
            axes.hlines(target, place - 0.42, place + 0.42, **TARGET)
        if not len(values):
            continue
        sideways = np.linspace(-SPREAD, SPREAD, len(values)) if len(values) > 1 else np.zeros(1)
        axes.plot(place + sideways, values, "o", ms=3.5, color=BLUE, alpha=0.55, mew=0)
        axes.hlines(float(np.mean(values)), place - 0.36, place + 0.36, color=VERMILION, lw=2.0)
    axes.set_xticks(range(len(groups)), list(groups))
    axes.set_xlim(-0.6, len(groups) - 0.4)
    axes.set_title(title, fontsize=10)


def explain(figure: Figure, axes: Axes) -> None:
    """Add the legend of `draw_groups` below the panels."""
    axes.plot([], [], "o", ms=3.5, color=BLUE, alpha=0.55, mew=0, label="one run")
    axes.plot([], [], color=VERMILION, lw=2.0, label="mean")
    axes.plot([], [], **TARGET, label="target")
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8, frameon=False)


def save(figure: Figure, file: Path) -> None:
    """Write a PNG; equal figures give equal bytes."""
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, format="png", metadata={"Software": None})
