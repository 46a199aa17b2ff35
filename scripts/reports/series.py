"""How the numbers of a run went over time: what the charts of a report and of a figure show."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse.csgraph import connected_components

from reports.run_record import RunRecord
from swarm_msgs_py.messages.report import Positioning
from swarm_msgs_py.types import MISSION, BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """One line of a chart.

    Attributes
    ----------
    label : str
    values : (m,) array
        At the times of the chart; NaN where there is none.
    """

    label: str
    values: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """Lines over time that share a unit.

    Attributes
    ----------
    name : str
        Identifier, for the command line and file names.
    title : str
    unit : str
    times : (m,) array
        [s].
    lines : tuple of Series
    """

    name: str
    title: str
    unit: str
    times: FloatArray
    lines: tuple[Series, ...]


def charts(record: RunRecord) -> tuple[Chart, ...]:
    """Return the charts that a run has the numbers for, the most telling first."""
    if not record.ticks:
        return ()
    makers: tuple[Callable[[RunRecord], Chart | None], ...] = (
        _covered,
        _structure,
        _goal_distance,
        _localization,
        _modes,
        _motion,
        _gap,
        _connectivity,
        _traffic,
    )
    return tuple(chart for make in makers if (chart := make(record)) is not None)


def goal_distances(record: RunRecord) -> FloatArray:
    """Return how far each robot is from its goal, (t, n) [m]: NaN without one, and of the dead."""
    goals, positions = record.point_sets("goals"), record.edge_positions[:-1]
    distances = np.full(positions.shape[:2], np.nan)
    for tick, chosen in enumerate(record.arrays["goal"]):
        places = goals.at(tick)
        has = (chosen >= 0) & (chosen < len(places)) & record.arrays["alive"][tick]
        distances[tick, has] = np.linalg.norm(positions[tick, has] - places[chosen[has]], axis=-1)
    return distances


def links_by_tick(record: RunRecord) -> Iterator[BoolArray]:
    """Yield who is linked to whom in each tick, (n + 1, n + 1); the mission computer comes after the last robot.

    It is one array, which changes: whoever keeps it, copies it.
    """
    row_of = {node: row for row, node in enumerate((*record.robots, MISSION))}
    ends = np.array([[row_of[a], row_of[b]] for a, b in record.arrays["link_nodes"].tolist()], dtype=np.int64)
    ends, up = ends.reshape(-1, 2), record.arrays["link_up"]
    bounds = np.searchsorted(record.arrays["link_tick"], np.arange(record.ticks + 1))
    linked = np.zeros((len(row_of), len(row_of)), dtype=bool)
    for first, last in pairwise(bounds):
        for a, b in (ends[first:last].T, ends[first:last, ::-1].T):
            linked[a, b] = up[first:last]  # where one changed twice, the last stands
        yield linked


def _covered(record: RunRecord) -> Chart | None:
    if not record.has("covered_share"):
        return None
    lines = (Series("by robots at their places", record.arrays["covered_share"]),)
    return Chart("covered", "Covered share of the shape", "", record.arrays["covered_time"], lines)


def _structure(record: RunRecord) -> Chart | None:
    """Return how a structure of boats grows."""
    if not record.has("filled") or "dock_tick" not in record.arrays:
        return None
    counts = np.concatenate([[0], np.cumsum(np.where(record.arrays["dock_up"], 1, -1))])
    docks = counts[np.searchsorted(record.arrays["dock_tick"], np.arange(record.ticks), side="right")]
    lines = (Series("places filled", record.arrays["filled"].astype(np.float64)), Series("docks", docks.astype(float)))
    return Chart("structure", "Structure", "", record.arrays["tick_time"], lines)


def _goal_distance(record: RunRecord) -> Chart | None:
    if not record.has("goal", "goals_tick") or not record.has("goals_points"):
        return None
    distances = goal_distances(record)
    lines = (Series("largest", _over_robots(np.max, distances)), Series("mean", _over_robots(np.mean, distances)))
    return Chart("goal-distance", "Distance to the goal", "m", record.arrays["tick_time"], lines)


def _localization(record: RunRecord) -> Chart | None:
    """Return the errors of those that cannot measure where they are; of all, if all can."""
    if not record.has("estimate", "covariance"):
        return None
    alive = record.arrays["alive"]
    carries = record.arrays.get("carries_sensor", np.zeros(alive.shape[1], dtype=bool))
    counted = alive & ~carries if not carries.all() else alive
    errors = np.linalg.norm(record.arrays["estimate"] - record.edge_positions[:-1], axis=-1)
    claimed = np.sqrt(np.trace(record.arrays["covariance"], axis1=-2, axis2=-1))
    errors, claimed = np.where(counted, errors, np.nan), np.where(counted, claimed, np.nan)
    lines = (
        Series("largest", _over_robots(np.max, errors)),
        Series("rms", _over_robots(_rms, errors)),
        Series("rms as the robots believe", _over_robots(_rms, claimed)),
    )
    return Chart("localization", "Localization error", "m", record.arrays["tick_time"], lines)


def _modes(record: RunRecord) -> Chart | None:
    if not record.has("mode"):
        return None
    alive, modes = record.arrays["alive"], record.arrays["mode"]
    lines = [
        Series(name, _count((modes == mode) & alive))
        for mode, name in enumerate(record.mode_names)
        if ((modes == mode) & alive).any()
    ]
    if record.has("positioning"):
        is_lost = (record.arrays["positioning"] >= Positioning.LOST) & alive
        lines += [Series("lost", _count(is_lost))] if is_lost.any() else []
    lines += [Series("off", _count(~alive))] if not alive.all() else []
    return Chart("modes", "Robots by mode", "robots", record.arrays["tick_time"], tuple(lines))


def _motion(record: RunRecord) -> Chart | None:
    steps = np.linalg.norm(np.diff(record.arrays["position"], axis=0), axis=-1).sum(axis=1)
    driven = np.concatenate([[0.0], np.cumsum(steps)])
    rows = np.searchsorted(record.arrays["time"], record.edge_times)
    return Chart("displacement", "Total displacement", "m", record.edge_times, (Series("all robots", driven[rows]),))


def _gap(record: RunRecord) -> Chart | None:
    if not record.has("clearance"):
        return None
    clearance = np.where(np.isfinite(record.arrays["clearance"]), record.arrays["clearance"], np.nan)
    return Chart("clearance", "Least free gap", "m", record.arrays["tick_time"], (Series("gap", clearance),))


def _connectivity(record: RunRecord) -> Chart | None:
    if not record.has("link_tick"):
        return None
    degrees, parts = [], []
    for alive, linked in zip(record.arrays["alive"], links_by_tick(record), strict=True):
        living = np.flatnonzero(np.append(alive, True))
        graph = linked[np.ix_(living, living)]
        degrees.append(float(graph.sum()) / len(living))
        parts.append(float(connected_components(graph, directed=False)[0]))
    lines = (Series("neighbors per radio", np.array(degrees)), Series("connected parts", np.array(parts)))
    return Chart("connectivity", "Radio mesh", "", record.arrays["tick_time"], lines)


def _traffic(record: RunRecord) -> Chart | None:
    if not record.has("radio_bytes"):
        return None
    rate = record.arrays["radio_bytes"] * 8.0 / 1000.0 / record.period_s
    return Chart("traffic", "Radio traffic", "kbit/s", record.arrays["tick_time"], (Series("all radios", rate),))


def _over_robots(reduce: Callable[[FloatArray], float], values: FloatArray) -> FloatArray:
    """Return what `reduce` makes of the finite numbers in each row, NaN where there are none."""
    return np.array([reduce(row[np.isfinite(row)]) if np.isfinite(row).any() else np.nan for row in values])


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _count(holds: np.ndarray) -> FloatArray:
    counts: FloatArray = holds.sum(axis=1).astype(np.float64)
    return counts
