"""The picture of a run: where everybody started, went and ended, in which shape, among which obstacles."""

from __future__ import annotations

import io
from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon

from bringup.layout import robot_types
from bringup.results import FormationMetrics
from bringup.scenario import Scenario
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics.trace import Trace

TYPE_COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9")  # Okabe-Ito: safe for color blindness
SHAPE_FILL, SHAPE_EDGE, WALL_FILL, WALL_EDGE, LOST = "#F0E9DA", "#7A6A4F", "#B8B8B8", "#555555", "#C00000"
WIDTH_IN, HEIGHT_IN, DPI = 12.0, 6.6, 150
DETAIL_MARGIN = 0.08  # free rim around the shape in the right panel, as a share of its size
LINE_SPACING_M = 0.05  # points of a drawn trajectory are at least this far apart
SMALL = 7.5  # font size of ticks and legend


def run_figure(scenario: Scenario, trace: Trace, plan: Plan | None, metrics: FormationMetrics) -> bytes:
    """Return the PNG of a run: the whole arena with all trajectories on the left, the formation on the right.

    Circles have their true size, both panels equal axes.
    """
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    arena, detail = figure.subplots(1, 2)
    types = robot_types(scenario)
    for axes in (arena, detail):
        _draw_scene(axes, scenario, plan)
        if len(trace.positions):
            _draw_trajectories(axes, trace.positions, types)
            _draw_robots(axes, trace, types)
        axes.set_aspect("equal")
        axes.set_xlabel("x [m]", fontsize=9)
        axes.tick_params(labelsize=SMALL)
    _draw_goals(detail, plan)
    _frame_arena(arena, scenario, trace)
    _frame_shape(detail, scenario, plan)
    arena.set_ylabel("y [m]", fontsize=9)
    arena.set_title("arena and trajectories", fontsize=10)
    detail.set_title("final formation", fontsize=10)
    figure.suptitle(_headline(metrics), fontsize=11)
    figure.legend(
        handles=_legend(scenario, types, metrics, plan),
        loc="outside lower center",
        ncols=8,
        fontsize=SMALL,
        frameon=False,
    )
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _draw_scene(axes: Axes, scenario: Scenario, plan: Plan | None) -> None:
    contour = plan.contour if plan is not None else np.array(scenario.shape.points)
    axes.add_patch(Polygon(contour, closed=True, facecolor=SHAPE_FILL, edgecolor=SHAPE_EDGE, linewidth=1.2, zorder=1))
    for outline in _earlier_shapes(scenario, contour):
        axes.add_patch(Polygon(outline, closed=True, fill=False, edgecolor=SHAPE_EDGE, linestyle=":", zorder=1))
    for obstacle in scenario.map.obstacles:
        wall = Polygon(
            obstacle.polygon(), closed=True, facecolor=WALL_FILL, edgecolor=WALL_EDGE, hatch="////", zorder=2
        )
        axes.add_patch(wall)


def _earlier_shapes(scenario: Scenario, last: FloatArray) -> list[FloatArray]:
    """Return the other shapes of a run, in their order."""
    specs = (scenario.shape, *(stage.shape for stage in scenario.stages if stage.shape is not None))
    contours = [np.array(spec.points) for spec in specs]
    return [contour for contour in contours if not np.array_equal(contour.round(2), last)]


def _draw_trajectories(axes: Axes, positions: FloatArray, types: tuple[RobotType, ...]) -> None:
    colors = _color_of(types)
    lines = [_thinned(positions[:, robot]) for robot in range(len(types))]
    line_colors = [colors[kind.type] for kind in types]
    axes.add_collection(LineCollection(lines, colors=line_colors, linewidths=0.8, alpha=0.6, zorder=3))
    for robot, kind in enumerate(types):
        axes.plot(*positions[0, robot], ".", color=colors[kind.type], markersize=3.5, zorder=4)


def _draw_robots(axes: Axes, trace: Trace, types: tuple[RobotType, ...]) -> None:
    colors = _color_of(types)
    circles = [
        Circle(
            tuple(trace.positions[-1, robot]),
            kind.coverage_radius_m,
            facecolor=colors[kind.type],
            edgecolor="black",
            linewidth=0.3,
        )
        for robot, kind in enumerate(types)
    ]
    axes.add_collection(PatchCollection(circles, match_original=True, zorder=5))
    lost = trace.positions[-1][~trace.alive[-1]]
    axes.plot(lost[:, 0], lost[:, 1], "x", color=LOST, markersize=7, markeredgewidth=1.8, zorder=7)


def _draw_goals(axes: Axes, plan: Plan | None) -> None:
    if plan is not None and len(plan.goals):
        axes.plot(plan.goals[:, 0], plan.goals[:, 1], "+", color="black", markersize=5, markeredgewidth=0.8, zorder=6)


def _frame_arena(axes: Axes, scenario: Scenario, trace: Trace) -> None:
    assert scenario.map.bounds_m is not None  # a resolved scenario has its map written out
    x_min, y_min, x_max, y_max = scenario.map.bounds_m
    if len(trace.positions):  # robots that strayed are part of the story
        x_min, y_min = np.minimum((x_min, y_min), trace.positions.min(axis=(0, 1)))
        x_max, y_max = np.maximum((x_max, y_max), trace.positions.max(axis=(0, 1)))
    axes.set_xlim(x_min, x_max)
    axes.set_ylim(y_min, y_max)
    _draw_scale_bar(axes, x_max - x_min)


def _frame_shape(axes: Axes, scenario: Scenario, plan: Plan | None) -> None:
    contour = plan.contour if plan is not None else np.array(scenario.shape.points)
    low, high = contour.min(axis=0), contour.max(axis=0)
    center, half = 0.5 * (low + high), 0.5 * float((high - low).max()) * (1.0 + 2.0 * DETAIL_MARGIN)
    axes.set_xlim(center[0] - half, center[0] + half)
    axes.set_ylim(center[1] - half, center[1] + half)
    _draw_scale_bar(axes, 2.0 * half)


def _draw_scale_bar(axes: Axes, width: float) -> None:
    """Draw a bar of a round length, about a fifth of the panel, into its lower left corner."""
    step = 10.0 ** np.floor(np.log10(0.2 * width))
    length = float(max(factor * step for factor in (1.0, 2.0, 5.0) if factor * step <= 0.2 * width))
    x, y = 0.04, 0.04
    axes.plot([x, x + length / width], [y, y], "k-", linewidth=2.5, transform=axes.transAxes, zorder=8)
    place = (x + 0.5 * length / width, y + 0.012)
    axes.text(*place, f"{length:g} m", ha="center", fontsize=SMALL, transform=axes.transAxes, zorder=8)


def _headline(metrics: FormationMetrics) -> str:
    outcome = "achieved" if metrics.achieved else "not achieved"
    parts = [f"{metrics.scenario}, {metrics.method}, seed {metrics.seed}: {outcome}", f"{metrics.robots} robots"]
    if metrics.settling_time_s is not None:
        parts.append(f"settled after {metrics.settling_time_s:.1f} s")
    parts.append(f"total displacement {metrics.total_displacement_m:.0f} m")
    if metrics.displacement_ratio is not None:
        parts.append(f"{metrics.displacement_ratio:.2f} x lower bound")
    return "  |  ".join(parts)


def _legend(
    scenario: Scenario, types: tuple[RobotType, ...], metrics: FormationMetrics, plan: Plan | None
) -> list[Line2D | Patch]:
    has_stages = bool(scenario.stages)
    handles: list[Line2D | Patch] = []
    for number, color in _color_of(types).items():
        label = f"type {number} (r = {_radius(types, number):g} m)"
        handles.append(Line2D([], [], color=color, marker="o", linewidth=0.8, markersize=7, label=label))
    handles.append(Line2D([], [], color="black", marker=".", linestyle="", markersize=4, label="start"))
    if plan is None or plan.task.has_goals:
        handles.append(Line2D([], [], color="black", marker="+", linestyle="", markersize=6, label="goal"))
    handles += [
        Patch(facecolor=SHAPE_FILL, edgecolor=SHAPE_EDGE, label="last shape" if has_stages else "shape"),
        *([Line2D([], [], color=SHAPE_EDGE, linestyle=":", label="earlier shape")] if has_stages else []),
        Patch(facecolor=WALL_FILL, edgecolor=WALL_EDGE, hatch="////", label="obstacle"),
    ]
    if metrics.lost_robots:
        handles.append(Line2D([], [], color=LOST, marker="x", linestyle="", markersize=7, label="lost robot"))
    return handles


def _color_of(types: Iterable[RobotType]) -> dict[int, str]:
    numbers = sorted({kind.type for kind in types})
    return {number: TYPE_COLORS[index % len(TYPE_COLORS)] for index, number in enumerate(numbers)}


def _radius(types: tuple[RobotType, ...], number: int) -> float:
    return next(kind.coverage_radius_m for kind in types if kind.type == number)


def _thinned(line: FloatArray) -> FloatArray:
    """Return a trajectory with about one point per `LINE_SPACING_M` of travel, both ends kept."""
    travel = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    keep = np.flatnonzero(np.diff(np.floor(travel / LINE_SPACING_M), prepend=-1.0))
    thinned: FloatArray = line[np.union1d(keep, [len(line) - 1])]
    return thinned
