"""The picture of a shape before a run: its contour, and the circles of the robots that it is to hold."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch, Polygon

from previews.shape_preview import ShapePreview
from reports.palette import SHAPE_EDGE, SHAPE_FILL, TYPE_COLORS, WALL_EDGE, WALL_FILL
from swarm_msgs_py.types import FloatArray

SIZE_IN, DPI = 7.0, 150
MARGIN = 0.08  # free rim around the shape, as a share of its size


def preview_figure(preview: ShapePreview, obstacles: tuple[FloatArray, ...], suffix: str) -> bytes:
    """Return the picture in the format of a file name's suffix: ``.png``, ``.svg`` or ``.pdf``."""
    figure = Figure(figsize=(SIZE_IN, SIZE_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.add_patch(Polygon(preview.contour, facecolor=SHAPE_FILL, edgecolor=SHAPE_EDGE, linewidth=1.2))
    for outline in obstacles:
        axes.add_patch(Polygon(outline, facecolor=WALL_FILL, edgecolor=WALL_EDGE, hatch="////"))
    colors = dict(zip((group.type for group in preview.roster.groups), TYPE_COLORS, strict=False))
    if preview.goals is not None:
        radii = preview.roster.radii_of(preview.goals.types)
        circles = [
            Circle((float(x), float(y)), float(radius), facecolor=colors[int(number)], edgecolor="black", linewidth=0.3)
            for (x, y), radius, number in zip(preview.goals.positions, radii, preview.goals.types, strict=True)
        ]
        axes.add_collection(PatchCollection(circles, match_original=True))
    low, high = preview.contour.min(axis=0), preview.contour.max(axis=0)
    rim = MARGIN * float(np.max(high - low))
    axes.set_xlim(low[0] - rim, high[0] + rim)
    axes.set_ylim(low[1] - rim, high[1] + rim)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    verdict = "fit" if preview.fits else "do not fit"
    axes.set_title(f"{preview.label}: {preview.area:.4g} m², {preview.roster.size} robots {verdict}")
    figure.legend(
        handles=[
            Patch(
                color=colors[group.type], label=f"{group.count} of type {group.type}, r = {group.coverage_radius_m:g} m"
            )
            for group in preview.roster.groups
        ],
        loc="outside lower center",
        ncols=3,
        fontsize=8,
        frameon=False,
    )
    buffer = io.BytesIO()
    figure.savefig(buffer, format=suffix.removeprefix("."))
    return buffer.getvalue()


FORMATS = (".pdf", ".png", ".svg")
"""Suffixes of what can be written."""


def is_picture(path: Path) -> bool:
    """Return whether a file name says a format that can be written."""
    return path.suffix.lower() in FORMATS
