"""How well a swarm follows a shape that moves (spec section 14.6)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import KDTree

from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.types import BoolArray, FloatArray

REACH = 0.65  # hexagonal spacings; what is farther from every robot is uncovered
LAG_MAX = 20.0  # [s]; longest lag that is looked for
STEP = 0.25  # [s]; of time, and of the lag
GRID_STEPS, SIDE_STEPS = 6, 50  # of the grid on which areas are measured, per reach, and per root of the area at least
UNCOVERED_SLACK = 0.03  # recovered when no more than this is uncovered beyond what stays so
# Of a misfit, 0.0026: standard deviation of rounding what one robot covers to whole points of the grid.
RESOLUTION = 12.0**-0.5 / (np.pi * GRID_STEPS**2)
TIE = 1e-9  # [s]; times that differ by less are equal


@dataclass(frozen=True, slots=True)
class MorphMetrics:
    """How a swarm followed one motion.

    Attributes
    ----------
    latency_s : float
        Lag behind the shape at which the swarm fits it best: least mean of uncovered and outside share. Where lags fit
        as well but for what the grid resolves (`RESOLUTION`), the least of them.
    outside_mean, outside_max : float
        Share of robots outside the shape as it is at the time, over the motion.
    uncovered_mean : float
        Share of the shape's area that is farther than 0.65 hexagonal spacings from every robot, over the motion.
    recovery_s : float or None
        How long after the end of the motion, until everybody is inside for good and the uncovered share is within 0.03
        of its last value; None if that is never.
    """

    latency_s: float
    outside_mean: float
    outside_max: float
    uncovered_mean: float
    recovery_s: float | None


def morph_metrics(
    times: FloatArray,
    positions: FloatArray,
    contour_of: Callable[[float], FloatArray],
    begins_s: float,
    ends_s: float,
) -> MorphMetrics:
    """Evaluate spec 14.6 on the record of a motion and of what comes after it.

    The specification leaves open which lag counts where several fit the shape alike, as while it grows or hardly moves:
    here, it is the least. A swarm is behind only as far as its misfit tells: a lag that is exact comes out up to half a
    second too short.

    Parameters
    ----------
    times : (s,) array
        Ascending; the record ends where the next motion begins [s].
    positions : (s, n, 2) array
        True positions of the robots that count, n >= 1 [m].
    contour_of : callable
        Returns the (k, 2) contour [m] at a time [s], also before the motion.
    begins_s, ends_s : float
        Of the motion, within the record [s].

    Raises
    ------
    ValueError
        If the motion is not within the record.
    """
    if not times[0] - TIE <= begins_s < ends_s <= times[-1] + TIE:
        raise ValueError(f"a motion from {begins_s:g} to {ends_s:g} s in a record from {times[0]:g} to {times[-1]:g} s")
    lags = round(LAG_MAX / STEP)
    count = int((times[-1] - begins_s) / STEP + TIE) + 1
    moments: FloatArray = (begins_s + STEP * np.arange(count)).astype(np.float64)
    moving = moments <= ends_s + TIE
    robots = _at(times, positions, moments)
    contours = [contour_of(float(moment)) for moment in begins_s + STEP * np.arange(-lags, len(moments))]
    outside = _outside(robots, contours)
    uncovered = _uncovered(robots, contours, lags)
    rows = np.arange(len(moments))
    behind = rows[:, None] + lags - np.arange(lags + 1)  # (moments, lags): the contour as it was so long ago
    misfit = (outside[rows[:, None], behind] + uncovered[rows[:, None], behind])[moving].mean(axis=0)
    fitting = np.flatnonzero(misfit <= misfit.min() + RESOLUTION)
    now = outside[rows, rows + lags], uncovered[rows, rows + lags]
    return MorphMetrics(
        latency_s=STEP * float(fitting[0]),
        outside_mean=float(now[0][moving].mean()),
        outside_max=float(now[0][moving].max()),
        uncovered_mean=float(now[1][moving].mean()),
        recovery_s=_recovery(moments - ends_s, *now),
    )


def _at(times: FloatArray, positions: FloatArray, moments: FloatArray) -> FloatArray:
    """Return the positions at other times, between those of the record, (m, n, 2)."""
    after = np.clip(np.searchsorted(times, moments), 1, len(times) - 1)
    share = ((moments - times[after - 1]) / (times[after] - times[after - 1]))[:, None, None]
    at: FloatArray = positions[after - 1] + share * (positions[after] - positions[after - 1])
    return at


def _outside(robots: FloatArray, contours: list[FloatArray]) -> FloatArray:
    """Return the share of robots outside at each moment, for each contour, (moments, contours)."""
    shares = []
    for contour in contours:
        shape = shapely.Polygon(contour)
        shapely.prepare(shape)
        shares.append(1.0 - shapely.contains_xy(shape, robots[..., 0], robots[..., 1]).mean(axis=1))
    return np.stack(shares, axis=1)


def _uncovered(robots: FloatArray, contours: list[FloatArray], first: int) -> FloatArray:
    """Return the share of each contour's area that is uncovered at each moment, (moments, contours).

    Shapes and what robots cover are sets of points of one grid, so that all pairs of them are one matrix product. The
    reach is that of the contour at the moment, `contours[first]` at the first one.
    """
    areas = np.array([signed_area(contour) for contour in contours[first:]])
    reaches = REACH * np.sqrt(2.0 * areas / (np.sqrt(3.0) * robots.shape[1]))
    corners = np.concatenate(contours)
    step = min(float(reaches.min()) / GRID_STEPS, float(areas.min()) ** 0.5 / SIDE_STEPS)
    axes = [np.arange(low + 0.5 * step, high, step) for low, high in zip(corners.min(0), corners.max(0), strict=True)]
    x, y = (grid.ravel() for grid in np.meshgrid(*axes))
    inside = np.stack([_contains(contour, x, y) for contour in contours])
    ever = inside.any(axis=0)
    inside, grid = inside[:, ever], np.column_stack([x[ever], y[ever]])
    distances = np.stack([
        KDTree(places).query(grid, distance_upper_bound=reach)[0]
        for places, reach in zip(robots, reaches, strict=True)
    ])  # fmt: skip
    covered = np.isfinite(distances)
    within = covered.astype(np.float32) @ inside.T.astype(np.float32)
    uncovered: FloatArray = 1.0 - within.astype(np.float64) / np.maximum(inside.sum(axis=1), 1)
    return uncovered


def _contains(contour: FloatArray, x: FloatArray, y: FloatArray) -> BoolArray:
    shape = shapely.Polygon(contour)
    shapely.prepare(shape)
    inside: BoolArray = shapely.contains_xy(shape, x, y)
    return inside


def _recovery(since: FloatArray, outside: FloatArray, uncovered: FloatArray) -> float | None:
    """Return the first of the times since the end from which on the swarm fits the shape, None if it never does."""
    fits = (outside <= 0.0) & (uncovered <= uncovered[-1] + UNCOVERED_SLACK)
    if not fits[-1]:
        return None
    unfit = np.flatnonzero(~fits)
    first = int(unfit[-1]) + 1 if len(unfit) else 0
    return max(float(since[first]), 0.0)
