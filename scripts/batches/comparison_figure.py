"""The picture of a comparison: a panel per quantity, the methods side by side at every shape."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from batches.cells import Cell
from batches.comparison import Comparison
from batches.estimates import LEVEL
from batches.quantities import OF_SETTLED, QUANTITIES, SHARE, Quantity
from reports.palette import TYPE_COLORS

WIDTH_IN, HEIGHT_IN, DPI = 13.0, 7.2, 150
COLUMNS = 3
GROUP_WIDTH = 0.8  # of the distance from shape to shape that the boxes of one shape take
TINY, SMALL, MEDIUM, LARGE = 6, 8, 9, 11  # font sizes
WHISKERS = (2.5, 97.5)  # percentiles


def comparison_figure(comparison: Comparison) -> bytes | None:
    """Return the PNG; None without any result.

    Boxes show the quartiles and the median of the runs, whiskers the middle 95 %, dots the runs beyond. The last panel
    has the achieved share with its confidence interval, and the number of collisions above it.
    """
    places = comparison.places
    if not places:
        return None
    drawn = [quantity for quantity in QUANTITIES if quantity.is_drawn]
    rows = -(-(len(drawn) + 1) // COLUMNS)
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel().tolist()
    for panel, quantity in zip(panels, drawn, strict=False):
        _draw_boxes(panel, comparison, quantity)
    _draw_shares(panels[len(drawn)], comparison)
    for panel in panels[len(drawn) + 1 :]:
        panel.set_axis_off()
    for panel in panels[: len(drawn) + 1]:
        _finish(panel, _names(places))
    most = max(comparison.count(cell) for cell in comparison.cells)
    figure.suptitle(
        f"up to {most} random starts per method and shape, the same for all methods; boxes: quartiles, whiskers: 95 %",
        fontsize=LARGE,
    )
    handles = [Patch(facecolor=_color(comparison, name), label=name) for name in comparison.variants]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=MEDIUM, frameon=False)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw_boxes(axes: Axes, comparison: Comparison, quantity: Quantity) -> None:
    is_of_settled = quantity.name in OF_SETTLED
    unsettled = [cell for cell in comparison.cells if is_of_settled and not comparison.all_settled(cell)]
    axes.set_title(f"{quantity.label}; above: settled/runs" if unsettled else quantity.label, fontsize=MEDIUM)
    if unsettled:
        axes.margins(y=0.12)
    for cell, place, width in _columns(comparison):
        if cell in unsettled:
            label, above = comparison.settled(cell), axes.get_xaxis_transform()  # in places across, in shares upwards
            axes.text(place, 0.99, label, ha="center", va="top", fontsize=TINY, transform=above)
        values = np.array(list(comparison.values(cell, quantity).values()))
        if len(values):
            box = axes.boxplot(
                [values],
                positions=[place],
                widths=[0.85 * width],
                whis=WHISKERS,
                patch_artist=True,
                manage_ticks=False,
                medianprops={"color": "black", "linewidth": 0.9},
                flierprops={"marker": ".", "markersize": 3, "markeredgecolor": "0.4"},
                boxprops={"linewidth": 2.5},  # so that a box without height shows its color
            )
            box["boxes"][0].set_color(_color(comparison, cell.variant))
    if not axes.patches:
        axes.text(0.5, 0.5, "no run has it", ha="center", transform=axes.transAxes, fontsize=MEDIUM, color="0.4")


def _draw_shares(axes: Axes, comparison: Comparison) -> None:
    axes.set_title(f"achieved share, {LEVEL:.0%} interval; above: collisions", fontsize=MEDIUM)
    collisions = next(quantity for quantity in QUANTITIES if quantity.name == "collisions")
    for cell, place, width in _columns(comparison):
        found = comparison.estimate(cell, SHARE)
        if found is None or found.low is None or found.high is None:
            continue
        axes.bar(place, found.mean, 0.85 * width, color=_color(comparison, cell.variant))
        spread = [[max(found.mean - found.low, 0.0)], [max(found.high - found.mean, 0.0)]]
        axes.errorbar(place, found.mean, yerr=spread, color="black", capsize=2.5, linewidth=0.9)
        total = sum(comparison.values(cell, collisions).values())
        axes.text(place, 1.03, f"{total:.0f}", ha="center", va="bottom", fontsize=SMALL)
    axes.set_ylim(0.0, 1.13)


def _columns(comparison: Comparison) -> list[tuple[Cell, float, float]]:
    """Return each cell with its place on the axis and the room that it has there."""
    variants = comparison.variants
    width = GROUP_WIDTH / len(variants)
    return [
        (cell, group + (variants.index(cell.variant) + 0.5) * width - 0.5 * GROUP_WIDTH, width)
        for group, place in enumerate(comparison.places)
        for cell in comparison.at(place)
    ]


def _names(places: Sequence[tuple[str, str]]) -> list[str]:
    """Return what the axis says of each place: the shape, and the scenario if there are several."""
    is_one = len({scenario for scenario, _ in places}) == 1
    return [shape if is_one else f"{shape}\n{scenario}" for scenario, shape in places]


def _finish(axes: Axes, names: Sequence[str]) -> None:
    axes.set_xticks(range(len(names)), labels=list(names), fontsize=SMALL)
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.tick_params(axis="y", labelsize=SMALL)
    axes.grid(visible=True, axis="y", color="0.9")
    axes.set_axisbelow(True)


def _color(comparison: Comparison, variant: str) -> str:
    return TYPE_COLORS[comparison.variants.index(variant) % len(TYPE_COLORS)]
