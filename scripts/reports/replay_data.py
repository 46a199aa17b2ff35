"""The run as the report's JavaScript plays it: frames, packed small."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from reports.packing import packed, packed_whole
from reports.run_record import PointSets, RunRecord
from reports.thinning import thinned, thinned_pairs
from swarm_msgs_py.types import MISSION, FloatArray, IntArray, robot_name

STEP_M = 0.005  # resolution of positions at most: a tenth of a pixel in an arena of fifty meters
STEP_SHARE = 0.01  # and no coarser than this share of the smallest radius
STEP_RAD = 0.01
ROBOT_FRAMES_MAX = 120_000  # frames times robots; longer runs of larger swarms are shown with fewer frames
POINTS_MAX = 60_000  # of all paths together, and of shapes and goals; of longer runs, fewer changes of them are shown
PAIR_CHANGES_MAX = 100_000  # the same for links and docks
ALERTS_MAX = 1000
ELLIPSE_SIGMAS = 2.0  # of the error ellipses: in two dimensions, 86 % of the errors of an honest robot are inside


def replay_data(record: RunRecord) -> dict[str, Any]:
    """Return everything that changes while the replay runs, and what stands still in it.

    Times are in frames of the replay: the start of every tick, or of every k-th in large runs, and the end.
    """
    chosen = frame_rows(record)
    paths = record.paths()
    told = {"shape": [record.point_sets("shape")], "goals": [record.point_sets("goals")], "paths": [*paths.values()]}
    changes = {name: _changes(sets, chosen) for name, sets in told.items()}
    pairs = {name: _pair_changes(record, name, chosen) for name in ("link", "dock")}
    times, positions = record.edge_times[chosen], record.edge_positions[chosen]
    step_m = min(STEP_M, STEP_SHARE * float(record.radii.min(initial=np.inf)))
    data: dict[str, Any] = {
        "times": [round(float(time), 3) for time in times],
        "names": [robot_name(robot) for robot in record.robots],  # type: ignore[arg-type]
        "radius": [round(float(radius), 3) for radius in record.radii],
        "position": packed(positions, step_m),
        "modes": list(record.mode_names),
        "obstacles": [corners.round(3).tolist() for corners in record.obstacles()],
        "shape": changes["shape"].sets[0],
        "goals": changes["goals"].sets[0],
        "paths": changes["paths"].sets,
        "alerts": _alerts(record, chosen)[:ALERTS_MAX],
        "links": pairs["link"].data if pairs["link"] else None,
        "docks": pairs["dock"].data if pairs["dock"] else None,
        "steps": _steps(chosen, {**changes, "links": pairs["link"], "docks": pairs["dock"]}),
    }
    for name in ("robot_type", "carries_sensor"):
        if record.has(name):
            data[name] = record.arrays[name].astype(int).tolist()
    for name in ("bounds", "mission_position"):
        if record.has(name):
            data[name] = record.arrays[name].round(3).tolist()
    if not record.ticks:
        return data
    for name in ("alive", "mode", "goal", "positioning"):
        if record.has(name):
            data[name] = packed_whole(record.edge_states(name)[chosen])
    if record.has("yaw"):
        data["yaw"] = packed(record.edge_states("yaw")[chosen], STEP_RAD)
    if record.has("estimate", "covariance"):
        axes, turns = _ellipses(record.edge_states("covariance")[chosen])
        data["estimate"] = packed(record.edge_states("estimate")[chosen], step_m)
        data["ellipse"] = packed(axes, step_m)
        data["ellipse_turn"] = packed(turns, STEP_RAD)
    return data


def frame_rows(record: RunRecord) -> IntArray:
    """Return which of the run's `edge_times` the replay shows, (f,), the first and the last among them."""
    count, robots = len(record.edge_times), len(record.robots)
    stride = max(1, math.ceil(count * robots / ROBOT_FRAMES_MAX))
    return np.union1d(np.arange(0, count, stride), np.arange(count)[-1:])


def _frame_of(ticks: IntArray, chosen: IntArray) -> list[int]:
    """Return the first frame that shows what happened at each tick."""
    return np.searchsorted(chosen, ticks).clip(max=max(len(chosen) - 1, 0)).tolist()  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True)
class _Changes:
    """Sets of points over time, as the JavaScript takes them, and every how many frames they may change."""

    sets: list[Mapping[str, Any]]
    step: int


@dataclass(frozen=True, slots=True)
class _PairChanges:
    """The same of pairs."""

    data: Mapping[str, Any]
    step: int


def _changes(told: Sequence[PointSets], chosen: IntArray) -> _Changes:
    """Return sets of points that share the room there is."""
    frames = [np.array(_frame_of(sets.ticks, chosen), dtype=np.int64) for sets in told]
    sizes = [np.array([len(points) for points in sets.points], dtype=np.int64) for sets in told]
    things = np.repeat(np.arange(len(told)), [len(sets.points) for sets in told])
    nothing = np.empty(0, dtype=np.int64)
    left = thinned(
        np.concatenate([nothing, *frames]), things, np.concatenate([nothing, *sizes]), POINTS_MAX, len(chosen) - 1
    )
    points = [points for sets in told for points in sets.points]
    shown: list[Mapping[str, Any]] = []
    for thing in range(len(told)):
        mine = things[left.rows] == thing
        kept = [points[row].round(3).tolist() for row in left.rows[mine]]
        shown.append({"frames": left.frames[mine].tolist(), "points": kept})
    return _Changes(shown, left.step)


def _steps(chosen: IntArray, changes: Mapping[str, _Changes | _PairChanges | None]) -> Mapping[str, int]:
    """Return every how many ticks robots are shown, and what changes less often, where it is not every tick."""
    stride = int(chosen[1] - chosen[0]) if len(chosen) > 2 else 1
    steps = {name: stride * each.step for name, each in changes.items() if each is not None and each.step > 1}
    return {"robots": stride, **steps} if stride > 1 else steps


def _alerts(record: RunRecord, chosen: IntArray) -> list[tuple[int, str]]:
    if not record.has("alert_tick"):
        return []
    texts = [str(text) for text in record.arrays["alert_text"]]
    return list(zip(_frame_of(record.arrays["alert_tick"], chosen), texts, strict=True))


def _pair_changes(record: RunRecord, name: str, chosen: IntArray) -> _PairChanges | None:
    """Return which pairs of nodes came together and parted, (l, 4): frame, two nodes, whether they came together.

    Nodes are given by their row, the mission computer after the last robot.
    """
    if not record.has(f"{name}_tick"):
        return None
    row_of = {robot: row for row, robot in enumerate(record.robots)} | {int(MISSION): len(record.robots)}
    pairs = np.vectorize(row_of.__getitem__, otypes=[np.int64])(record.arrays[f"{name}_nodes"])
    frames, is_up = np.array(_frame_of(record.arrays[f"{name}_tick"], chosen)), record.arrays[f"{name}_up"].astype(bool)
    left = thinned_pairs(frames, pairs, is_up, PAIR_CHANGES_MAX, len(chosen) - 1)
    columns = np.column_stack([left.frames, pairs[left.rows], is_up[left.rows]])
    return _PairChanges(packed_whole(columns[np.argsort(left.frames, kind="stable")]), left.step)


def _ellipses(covariances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return half axes (..., 2) [m] and direction of the longer one (...) [rad] of the error ellipses; NaN of none."""
    spread = 0.5 * (covariances[..., 0, 0] + covariances[..., 1, 1])
    skew, shared = 0.5 * (covariances[..., 0, 0] - covariances[..., 1, 1]), covariances[..., 0, 1]
    reach = np.hypot(skew, shared)
    axes = [np.sqrt(spread + reach), np.sqrt(np.maximum(spread - reach, 0.0))]
    return ELLIPSE_SIGMAS * np.stack(axes, axis=-1), 0.5 * np.arctan2(shared, skew)
