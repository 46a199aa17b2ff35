"""A finished run as its folder holds it: all that reports and figures are made from."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import FloatArray, IntArray

DOT = 0.008  # radius of robots that have none of their own, as a share of the ground that the swarm covers
METRICS, SCENARIO, TRAJECTORIES = "metrics.json", "scenario.yaml", "trajectories.npz"
MOMENT_S = 1e-9  # sample times are sums of fractions of a tick
NEEDED = ("time", "position", "tick_time", "alive")
"""Arrays without which there is nothing to show; the others may be missing, and what is made from them with them."""


@dataclass(frozen=True, slots=True, eq=False)
class PointSets:
    """Sets of points that change over time.

    Attributes
    ----------
    ticks : (k,) int array
        From when on each holds.
    points : tuple of (m, 2) array
        The sets [m].
    """

    ticks: IntArray
    points: tuple[FloatArray, ...]

    def at(self, tick: float) -> FloatArray:
        """Return the set that holds at a tick, empty before the first."""
        number = int(np.searchsorted(self.ticks, tick, side="right")) - 1
        return self.points[number] if number >= 0 else np.empty((0, 2))


@dataclass(frozen=True, slots=True, eq=False)
class RunRecord:
    """What is known of a run.

    Attributes
    ----------
    metrics : mapping
        As in ``metrics.json``.
    scenario : str
        Text of ``scenario.yaml``.
    arrays : mapping of str to array
        As in ``trajectories.npz`` (`bringup.trajectories` says what they are). A run of `t` ticks and `n` robots.
    """

    metrics: Mapping[str, Any]
    scenario: str
    arrays: Mapping[str, np.ndarray]

    @classmethod
    def load(cls, folder: Path) -> RunRecord:
        """Return what a run folder holds.

        Raises
        ------
        ConfigError
            If it is not the folder of a run, or something in it cannot be read.
        """
        missing = [name for name in (METRICS, SCENARIO, TRAJECTORIES) if not (folder / name).is_file()]
        if missing:
            raise ConfigError(f"{folder}: {missing[0]} is missing; name a folder that launch_swarm.py has written")
        try:
            metrics = json.loads((folder / METRICS).read_text(encoding="utf-8"))
            scenario = (folder / SCENARIO).read_text(encoding="utf-8")
            with np.load(folder / TRAJECTORIES) as stored:
                arrays = {name: stored[name] for name in stored.files}
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise ConfigError(f"{folder}: cannot be read ({error}); run the scenario again") from error
        lacking = [name for name in NEEDED if name not in arrays]
        if lacking:
            raise ConfigError(
                f"{folder / TRAJECTORIES}: has no '{lacking[0]}', so another version wrote it; run the scenario again"
            )
        return cls(metrics, scenario, arrays)

    @property
    def robots(self) -> tuple[int, ...]:
        """Ids, ascending; the order of all robot axes. Where none are stored, the robots are numbered."""
        if "robot" in self.arrays:
            return tuple(int(robot) for robot in self.arrays["robot"])
        return tuple(range(self.arrays["position"].shape[1]))

    @property
    def radii(self) -> FloatArray:
        """Coverage radius of each robot, (n,) [m]; where none are stored, of a size that can be seen."""
        if "coverage_radius" in self.arrays:
            radii: FloatArray = self.arrays["coverage_radius"]
            return radii
        positions = self.arrays["position"].reshape(-1, self.arrays["position"].shape[-1])
        extent = float(np.ptp(positions, axis=0).max()) if len(positions) else 1.0
        return np.full(len(self.robots), DOT * extent)

    @property
    def ticks(self) -> int:
        """How many ticks the run had."""
        return len(self.arrays["tick_time"])

    @property
    def mode_names(self) -> tuple[str, ...]:
        """What the values of ``mode`` mean, from 0 on; numbered where no names are stored."""
        if "mode_names" in self.arrays:
            return tuple(str(name) for name in self.arrays["mode_names"])
        count = int(self.arrays["mode"].max(initial=-1)) + 1 if "mode" in self.arrays else 0
        return tuple(f"mode {number}" for number in range(count))

    @property
    def period_s(self) -> float:
        """Duration of a tick [s]; where it is not stored, the time between ticks."""
        if "period" in self.arrays:
            return float(self.arrays["period"])
        return float(np.median(np.diff(self.edge_times))) if self.ticks else 0.0

    @property
    def edge_times(self) -> FloatArray:
        """Start of each tick and the end of the last, (t + 1,) [s]; empty without a tick."""
        times: FloatArray = self.arrays["time"][self._edge_rows]
        return times

    @property
    def edge_positions(self) -> FloatArray:
        """True positions at those times, (t + 1, n, d) [m]."""
        positions: FloatArray = self.arrays["position"][self._edge_rows]
        return positions

    @property
    def _edge_rows(self) -> IntArray:
        times, starts = self.arrays["time"], self.arrays["tick_time"]
        rows = np.searchsorted(times, starts - MOMENT_S)
        return np.append(rows, len(times) - 1) if len(rows) else rows

    def edge_states(self, name: str) -> np.ndarray:
        """Return an array over ticks as one over `edge_times`: at the end it is what it was in the last tick."""
        values = self.arrays[name]
        return np.concatenate([values, values[-1:]])

    def has(self, *names: str) -> bool:
        """Return whether the run has all these arrays, and something in each."""
        return all(name in self.arrays and self.arrays[name].size > 0 for name in names)

    def point_sets(self, name: str) -> PointSets:
        """Return ``shape`` or ``goals`` over time; no sets at all if the run did not record any."""
        if f"{name}_tick" not in self.arrays:
            return PointSets(np.empty(0, dtype=np.int64), ())
        return PointSets(self.arrays[f"{name}_tick"], tuple(self._split(f"{name}_sizes", f"{name}_points")))

    def surface_at(self, edge: int) -> FloatArray:
        """Return points on the solid that is to be covered, where it is at one of the `edge_times`, (k, 3) [m]."""
        if not self.has("surfaces", "surface_shift"):
            points: FloatArray = self.arrays.get("surface_points", np.empty((0, 3)))
            return points
        number = int(np.searchsorted(self.arrays["surface_tick"], edge, side="right")) - 1
        moved: FloatArray = self.arrays["surfaces"][max(number, 0)] + self.edge_states("surface_shift")[edge]
        return moved

    def paths(self) -> Mapping[int, PointSets]:
        """Return the way-points of each robot over time."""
        if "path_tick" not in self.arrays:
            return {}
        ticks, robots = self.arrays["path_tick"], self.arrays["path_robot"]
        points = tuple(self._split("path_sizes", "path_points"))
        rows = {robot: np.flatnonzero(robots == robot) for robot in self.robots}
        return {robot: PointSets(ticks[mine], tuple(points[row] for row in mine)) for robot, mine in rows.items()}

    def obstacles(self) -> list[FloatArray]:
        """Return the corners of each obstacle, (k, 2) [m]."""
        return list(self._split("obstacle_sizes", "obstacle_corners")) if "obstacle_sizes" in self.arrays else []

    def _split(self, sizes: str, points: str) -> Iterator[FloatArray]:
        ends = np.cumsum(self.arrays[sizes])
        for size, end in zip(self.arrays[sizes], ends, strict=True):
            yield self.arrays[points][end - size : end]
