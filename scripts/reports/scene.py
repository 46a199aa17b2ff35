"""The swarm in its arena as a Matplotlib drawing, at any time of the run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from reports.palette import DEAD, DEAD_FILL, LOST, SHAPE_EDGE, SHAPE_FILL, TYPE_COLORS, WALL_EDGE, WALL_FILL
from reports.run_record import RunRecord
from swarm_msgs_py.messages.report import Positioning
from swarm_msgs_py.types import BoolArray, FloatArray

LINE_SPACING_M = 0.05  # points of a drawn trajectory are at least this far apart
FRAME_MIN_M = 1.0  # least size of what a panel is about
FRAME_MARGIN = 0.08  # free rim around what a panel is about, as a share of its size
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])  # corners of a cell of unit size
SMALL = 7.5  # font size of ticks and legend


def color_of(record: RunRecord) -> dict[int, str]:
    """Return the color of each type of robot."""
    numbers = np.unique(_types(record)).tolist()
    return {number: TYPE_COLORS[index % len(TYPE_COLORS)] for index, number in enumerate(numbers)}


def draw_ground(axes: Axes, record: RunRecord) -> None:
    """Draw what never moves: obstacles, and the cells of a structure that is to be built."""
    if record.has("cell_size", "target_cells"):
        cells = record.arrays["target_cells"][:, None] + float(record.arrays["cell_size"]) * (SQUARE - 0.5)
        axes.add_collection(
            PolyCollection(list(cells), facecolors=SHAPE_FILL, edgecolors=SHAPE_EDGE, linewidths=0.8, zorder=1)
        )
    for corners in record.obstacles():
        axes.add_patch(Polygon(corners, closed=True, facecolor=WALL_FILL, edgecolor=WALL_EDGE, hatch="////", zorder=2))


def draw_shape(axes: Axes, contour: FloatArray) -> Polygon:
    """Draw the shape that the swarm is to form."""
    patch = Polygon(
        _drawable(contour), closed=True, facecolor=SHAPE_FILL, edgecolor=SHAPE_EDGE, linewidth=1.2, zorder=1
    )
    axes.add_patch(patch)
    return patch


def draw_earlier_shapes(axes: Axes, record: RunRecord) -> bool:
    """Draw, dotted, the shapes that stood before the last one; return whether there are any."""
    shapes = record.point_sets("shape")
    held = np.diff(np.append(shapes.ticks, record.ticks))
    earlier = [points for points, ticks in zip(shapes.points[:-1], held[:-1], strict=True) if ticks > 1]
    for outline in earlier:  # a shape on its way is another one in every tick
        axes.add_patch(Polygon(outline, closed=True, fill=False, edgecolor=SHAPE_EDGE, linestyle=":", zorder=1))
    return bool(earlier)


def draw_trajectories(axes: Axes, record: RunRecord, plane: Sequence[int] = (0, 1)) -> None:
    """Draw where everybody started and went."""
    positions, colors = record.arrays["position"][..., list(plane)], color_of(record)
    line_colors = [colors[kind] for kind in _types(record)]
    lines = [_thinned(positions[:, robot]) for robot in range(positions.shape[1])]
    axes.add_collection(LineCollection(lines, colors=line_colors, linewidths=0.8, alpha=0.6, zorder=3))
    axes.scatter(positions[0, :, 0], positions[0, :, 1], s=12, c=line_colors, linewidths=0, zorder=4)


def draw_surface(axes: Axes, record: RunRecord, edge: int, plane: Sequence[int] = (0, 1)) -> Line2D:
    """Draw points on the solid that is to be covered, where it is at one of the run's edge times."""
    points = record.surface_at(edge)[:, list(plane)]
    (marks,) = axes.plot(*points.T, ".", color=SHAPE_EDGE, markersize=1.0, alpha=0.4, zorder=1)
    return marks


class RobotMarks:
    """The robots of a run, movable from one time to another.

    Parameters
    ----------
    axes : Axes
    record : RunRecord
    plane : two ints
        Which coordinates are drawn.
    """

    def __init__(self, axes: Axes, record: RunRecord, plane: Sequence[int] = (0, 1)) -> None:
        self._record, self._plane = record, list(plane)
        colors = color_of(record)
        self._colors = [colors[kind] for kind in _types(record)]
        self._bodies = _squares(record) if record.has("cell_size") else _circles(axes, record)
        axes.add_collection(self._bodies)
        (self._dead,) = axes.plot([], [], "x", color=DEAD, markersize=7, markeredgewidth=1.8, zorder=7)

    def put(self, edge: int) -> Sequence[Artist]:
        """Put the robots where they are at one of the run's edge times; return what changed."""
        positions = self._record.edge_positions[edge][:, self._plane]
        alive = self._alive(edge)
        if isinstance(self._bodies, PolyCollection):
            self._bodies.set_verts(list(self._corners(edge, positions)))
        else:
            self._bodies.set_offsets(positions)
        faces = [color if lives else DEAD_FILL for color, lives in zip(self._colors, alive, strict=True)]
        self._bodies.set_facecolor(faces)
        lost = self._lost(edge)
        self._bodies.set_edgecolor([LOST if is_lost else "black" for is_lost in lost])
        self._bodies.set_linewidth([1.8 if is_lost else 0.3 for is_lost in lost])
        self._dead.set_data(*positions[~alive].T)
        return self._bodies, self._dead

    def _corners(self, edge: int, positions: FloatArray) -> FloatArray:
        """Return the corners of robots that are squares, (n, 4, 2) [m]."""
        yaws = self._record.edge_states("yaw")[edge] if self._record.has("yaw") else np.zeros(len(positions))
        cos, sin = np.cos(yaws), np.sin(yaws)
        turns = np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)
        square = 2.0 * self._record.radii[:, None, None] * (SQUARE - 0.5)
        corners: FloatArray = positions[:, None] + square @ turns.transpose(0, 2, 1)
        return corners

    def _alive(self, edge: int) -> BoolArray:
        alive: BoolArray = self._record.edge_states("alive")[edge]
        return alive

    def _lost(self, edge: int) -> BoolArray:
        if not self._record.has("positioning"):
            return np.zeros(len(self._colors), dtype=bool)
        lost: BoolArray = self._record.edge_states("positioning")[edge] >= Positioning.LOST
        return lost & self._alive(edge)


def _circles(axes: Axes, record: RunRecord) -> EllipseCollection:
    sizes = 2.0 * record.radii
    return EllipseCollection(
        sizes,
        sizes,
        np.zeros(len(sizes)),
        units="xy",
        offsets=np.zeros((len(sizes), 2)),
        offset_transform=axes.transData,
        linewidths=0.3,
        edgecolors="black",
        zorder=5,
    )


def _squares(record: RunRecord) -> PolyCollection:
    return PolyCollection(list(np.zeros((len(record.radii), 4, 2))), linewidths=0.3, edgecolors="black", zorder=5)


class GoalMarks:
    """The goals of a run, movable from one time to another."""

    def __init__(self, axes: Axes, record: RunRecord) -> None:
        self._goals = record.point_sets("goals")
        (self._marks,) = axes.plot([], [], "+", color="black", markersize=5, markeredgewidth=0.8, zorder=6)

    def put(self, tick: int) -> Sequence[Artist]:
        """Put the goals where they are at a tick; return what changed."""
        self._marks.set_data(*self._goals.at(tick)[:, :2].T)
        return (self._marks,)


def frame_arena(axes: Axes, record: RunRecord, plane: Sequence[int] = (0, 1)) -> None:
    """Show all of the arena; robots that strayed are part of the story."""
    positions = record.arrays["position"][..., list(plane)]
    corners = [positions.reshape(-1, 2)]
    if "bounds" in record.arrays and tuple(plane) == (0, 1):
        corners.append(record.arrays["bounds"].reshape(2, 2))
    if record.arrays["position"].shape[-1] > 2:  # panels of one size, which also show the solid
        space = np.concatenate([record.arrays["position"].reshape(-1, 3), record.surface_at(record.ticks)])
        low, high = space.min(axis=0), space.max(axis=0)
        half = 0.5 * float((high - low).max())
        middle = 0.5 * (low + high)[list(plane)]
        corners += [middle[None] - half, middle[None] + half]
    points = np.concatenate(corners)
    rim = float(record.radii.max())
    low, high = points.min(axis=0) - rim, points.max(axis=0) + rim
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    draw_scale_bar(axes, float(high[0] - low[0]))


def frame_points(axes: Axes, points: FloatArray) -> None:
    """Show a square around some points, with a rim."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = max(float((high - low).max()), FRAME_MIN_M)  # one point has none
    center, half = 0.5 * (low + high), 0.5 * size * (1.0 + 2.0 * FRAME_MARGIN)
    axes.set_xlim(center[0] - half, center[0] + half)
    axes.set_ylim(center[1] - half, center[1] + half)
    draw_scale_bar(axes, 2.0 * half)


def draw_scale_bar(axes: Axes, width: float) -> None:
    """Draw a bar of a round length, about a fifth of the panel, into its lower left corner."""
    step = 10.0 ** np.floor(np.log10(0.2 * width))
    length = float(max(factor * step for factor in (1.0, 2.0, 5.0) if factor * step <= 0.2 * width))
    x, y = 0.04, 0.04
    axes.plot([x, x + length / width], [y, y], "k-", linewidth=2.5, transform=axes.transAxes, zorder=8)
    place = (x + 0.5 * length / width, y + 0.012)
    axes.text(*place, f"{length:g} m", ha="center", fontsize=SMALL, transform=axes.transAxes, zorder=8)


def legend_handles(record: RunRecord, *, has_earlier_shapes: bool = False) -> list[Line2D | Patch]:
    """Return what the marks of the drawing mean, as far as the run has them."""
    handles: list[Line2D | Patch] = []
    types, radii = _types(record), record.radii
    for number, color in color_of(record).items():
        size = f" (r = {radii[types == number][0]:g} m)" if "coverage_radius" in record.arrays else ""
        label = f"type {number}{size}" if "robot_type" in record.arrays else f"robot{size}"
        handles.append(
            Line2D(
                [],
                [],
                color=color,
                marker="s" if record.has("cell_size") else "o",
                linewidth=0.8,
                markersize=7,
                label=label,
            )
        )
    handles.append(Line2D([], [], color="black", marker=".", linestyle="", markersize=4, label="start"))
    if record.has("goals_points"):
        handles.append(Line2D([], [], color="black", marker="+", linestyle="", markersize=6, label="goal"))
    if record.has("shape_points"):
        label = "last shape" if has_earlier_shapes else "shape"
        handles.append(Patch(facecolor=SHAPE_FILL, edgecolor=SHAPE_EDGE, label=label))
    if record.has("cell_size", "target_cells"):
        handles.append(Patch(facecolor=SHAPE_FILL, edgecolor=SHAPE_EDGE, label="place of the structure"))
    if len(record.surface_at(record.ticks)):
        handles.append(Line2D([], [], color=SHAPE_EDGE, marker=".", linestyle="", markersize=3, label="shape"))
    if has_earlier_shapes:
        handles.append(Line2D([], [], color=SHAPE_EDGE, linestyle=":", label="earlier shape"))
    if record.obstacles():
        handles.append(Patch(facecolor=WALL_FILL, edgecolor=WALL_EDGE, hatch="////", label="obstacle"))
    if record.ticks and not record.arrays["alive"][-1].all():
        handles.append(Line2D([], [], color=DEAD, marker="x", linestyle="", markersize=7, label="lost robot"))
    return handles


def _types(record: RunRecord) -> np.ndarray:
    """Return the type of each robot, (n,); all the same where the run knows none."""
    return record.arrays.get("robot_type", np.ones(len(record.robots), dtype=np.int64))


def _drawable(contour: FloatArray) -> FloatArray:
    return contour if len(contour) else np.full((1, 2), np.nan)  # Matplotlib refuses a polygon without points


def _thinned(line: FloatArray) -> FloatArray:
    """Return a trajectory with about one point per `LINE_SPACING_M` of travel, both ends kept."""
    travel = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    keep = np.flatnonzero(np.diff(np.floor(travel / LINE_SPACING_M), prepend=-1.0))
    thinned: FloatArray = line[np.union1d(keep, [len(line) - 1])]
    return thinned
