"""The recorded run: true motion and what the robots reported, as arrays over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.messages.camera_report import CameraReport
from swarm_msgs_py.messages.report import AgentReport
from swarm_msgs_py.types import FloatArray, IntArray, NodeId
from swarm_sim.metrics.camera import CameraScores, View, everybody
from swarm_sim.metrics.totals import RunTotals, run_totals
from swarm_sim.simulation import TickTruth

NOTHING = -1
"""Mode and goal of a robot that did not report in a tick."""


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A run of `t` ticks and `s` motion samples of `n` robots.

    Attributes
    ----------
    robots : tuple of NodeId
        Ascending; the order of all robot axes.
    tick_times : (t,) array
        Start of each tick [s].
    tick_positions : (t, n, 2) array
        True positions at the start of each tick [m].
    yaws : (t, n) array
        True headings at the start of each tick [rad].
    headings : (t, n) array
        That the robots believed in, NaN where they reported none [rad].
    alive : (t, n) bool array
        Whether the robot's electronics worked in the tick.
    estimates : (t, n, 2) array
        Position that the robot believed in, NaN where it reported none [m].
    covariances : (t, n, 2, 2) array
        Of those estimates, as the robot believed, NaN where it reported none [m^2].
    positioning : (t, n) int array
        Value of `Positioning` as reported, `NOTHING` where nothing was.
    beacons : (t, n) int array
        Beacons among the radio neighbors, as reported.
    modes, goals : (t, n) int array
        As reported, `NOTHING` where nothing was.
    sample_times : (s,) array
        Of the motion samples, the start first [s].
    positions, velocities : (s, n, 2) array
        True motion [m], [m/s].
    """

    robots: tuple[NodeId, ...]
    tick_times: FloatArray
    tick_positions: FloatArray
    yaws: FloatArray
    headings: FloatArray
    alive: np.ndarray
    estimates: FloatArray
    covariances: FloatArray
    positioning: IntArray
    beacons: IntArray
    modes: IntArray
    goals: IntArray
    sample_times: FloatArray
    positions: FloatArray
    velocities: FloatArray

    @property
    def sample_rate(self) -> float:
        """Motion samples per second [Hz], 0 without motion."""
        if len(self.sample_times) < 2:
            return 0.0
        return (len(self.sample_times) - 1) / float(self.sample_times[-1] - self.sample_times[0])


class TraceRecorder:
    """Collects ticks into a `Trace`.

    Parameters
    ----------
    robots : sequence of NodeId
        Ascending, in the order of the truth's rows.
    period_s : float
        Duration of a tick [s].
    view : View
        Whom the images of an overhead camera show.

    Attributes
    ----------
    camera : CameraScores
        How right the overhead camera was, where there is one.
    """

    def __init__(self, robots: Sequence[NodeId], period_s: float, view: View = everybody) -> None:
        self._robots = tuple(robots)
        self._row_of = {robot: row for row, robot in enumerate(self._robots)}
        self._period = period_s
        self.camera = CameraScores(view)
        self._truths: list[TickTruth] = []
        self._estimates: list[FloatArray] = []
        self._covariances: list[FloatArray] = []
        self._headings: list[FloatArray] = []
        self._states: list[IntArray] = []  # (n, 4): mode, goal, positioning, beacons

    def __len__(self) -> int:
        return len(self._truths)

    def record(
        self, truth: TickTruth, reports: Mapping[NodeId, AgentReport], camera: CameraReport | None = None
    ) -> None:
        """Append one tick, in which an image may have been taken."""
        count = len(self._robots)
        headings = np.full(count, np.nan)
        estimates, covariances = np.full((count, 2), np.nan), np.full((count, 2, 2), np.nan)
        states = np.full((count, 4), NOTHING, dtype=np.int64)
        states[:, 3] = 0
        for robot, report in reports.items():
            row = self._row_of[robot]
            estimates[row], covariances[row] = report.position, report.covariance
            headings[row] = report.yaw if np.isfinite(report.position).all() else np.nan
            states[row] = report.mode, report.goal, report.localization.positioning, report.beacons
        self._truths.append(truth)
        self._estimates.append(estimates)
        self._covariances.append(covariances)
        self._headings.append(headings)
        self._states.append(states)
        if camera is not None:
            self.camera.take(camera, self._row_of, truth.positions, truth.yaws)

    def totals(self) -> RunTotals:
        """Return the sums over everything recorded so far."""
        return run_totals(self._truths)

    def trace(self) -> Trace:
        """Return everything recorded so far; empty axes before the first tick."""
        count, truths = len(self._robots), self._truths
        ticks = len(truths)
        states = np.moveaxis(np.array(self._states, dtype=np.int64).reshape(ticks, count, 4), 2, 0)
        return Trace(
            robots=self._robots,
            tick_times=np.array([truth.time for truth in truths], dtype=np.float64),
            tick_positions=_stacked([truth.positions for truth in truths], (ticks, count, 2)),
            yaws=_stacked([truth.yaws for truth in truths], (ticks, count)),
            headings=_stacked(self._headings, (ticks, count)),
            alive=np.array([truth.alive for truth in truths], dtype=bool).reshape(ticks, count),
            estimates=_stacked(self._estimates, (ticks, count, 2)),
            covariances=_stacked(self._covariances, (ticks, count, 2, 2)),
            modes=states[0],
            goals=states[1],
            positioning=states[2],
            beacons=states[3],
            sample_times=sample_times(truths, self._period),
            positions=_joined([t.positions for t in truths[:1]], [t.samples for t in truths], count),
            velocities=_joined([t.velocities for t in truths[:1]], [t.sample_velocities for t in truths], count),
        )


def sample_times(truths: Sequence[TickTruth], period_s: float) -> FloatArray:
    """Return the times of the start of the first tick and of all samples after it, (s,) [s]."""
    times = [np.array([truth.time for truth in truths[:1]])]
    for truth in truths:
        times.append(truth.time + period_s * np.arange(1, len(truth.samples) + 1) / len(truth.samples))
    return np.concatenate(times).astype(np.float64)


def _stacked(parts: list[FloatArray], shape: tuple[int, ...]) -> FloatArray:
    return np.array(parts, dtype=np.float64).reshape(shape)


def _joined(start: list[FloatArray], parts: list[FloatArray], count: int) -> FloatArray:
    first = _stacked(start, (len(start), count, 2))
    return np.concatenate([first, *parts]).astype(np.float64)
