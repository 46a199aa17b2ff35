"""What is noted of a coverage run, when it is over, and what its numbers are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bringup.coverage.scenario import CoverageScenario
from bringup.coverage.starts import LEADER
from bringup.engine import TickRecord
from bringup.family import Metrics
from bringup.history import Chronicle, reported_modes
from bringup.run_numbers import run_numbers
from bringup.verdict import Timing, Verdict
from swarm_msgs_py.coverage_io import CoverageMode, CoverageReport
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.types import MISSION, FloatArray, NodeId
from swarm_sim.metrics.coverage import CoverageProbe, CoverageQuality
from swarm_sim.metrics.covering import Covering
from swarm_sim.points.simulation import PointTruth

CoverageRecord = TickRecord[PointTruth, CoverageReport]
"""One tick of the coverage family."""

COVERED_TICKS = 5
"""Between two looks at how much is covered so far, by `COVERED_PROBES` points: for the chart, not for the verdict."""

COVERED_PROBES = 2000
SURFACE_POINTS = 2000
"""On each shape, for pictures."""

PROBE_SEED = 0  # of the points by which coverage is measured: the same for all runs, so that methods are comparable


class CoverageAccount:
    """Implements `bringup.family.Account`.

    Parameters
    ----------
    scenario : CoverageScenario
        Resolved.
    """

    def __init__(self, scenario: CoverageScenario) -> None:
        self._scenario = scenario
        self._period = scenario.sim.period_s
        self._truths: list[PointTruth] = []
        self._modes: list[np.ndarray] = []
        self._covered: list[tuple[float, float]] = []  # time [s], share
        self._probes: list[tuple[int, dict[str, Any], CoverageProbe]] = []  # first tick, shape, and what measures it
        self._shifts: list[FloatArray] = []
        self._lost: frozenset[NodeId] = frozenset()
        self.covering = Covering(self._period)
        self._events = sorted(scenario.events, key=lambda event: event.at_s)
        self._passed = 0
        self._chronicle = Chronicle()

    def take(self, record: CoverageRecord) -> Verdict | None:
        """Take in one tick; return the verdict when there is one."""
        self._note_events(record)
        self.covering.take(record.truth, record.reports)
        self._truths.append(record.truth)
        self._chronicle.take(record, map(tuple, record.truth.links.tolist()))
        self._modes.append(reported_modes(record))
        self._note_shape(record.tick)
        if record.tick % COVERED_TICKS == 0:
            self._covered.append((record.truth.time + self._period, self._covered_share()))
        waiting = {NodeId(r) for event in self._events[self._passed :] for r in event.join}
        self._lost = frozenset(record.lost - waiting)
        end = record.truth.time + self._period
        if not record.truth.alive.any():
            return Verdict(False, "all robots are lost; see the alerts for why")
        if LEADER in self._lost and CoverageMode.HOLDING not in self.covering.modes.values():
            return Verdict(False, "the leader died before it had said what to do; nobody else knows the shape")
        if self.covering.is_over and self._passed == len(self._events) and end >= self._end_of_events + self._hold:
            return self._judged()
        if end >= self._scenario.duration_s - 1e-9:
            return Verdict(False, f"time limit of {self._scenario.duration_s:g} s: {self._tally()}")
        return None

    @property
    def ticks(self) -> int:
        """How many ticks were taken."""
        return len(self._truths)

    @property
    def alerts(self) -> tuple[str, ...]:
        """Nothing beside what the records say."""
        return ()

    @property
    def status(self) -> str:
        """How many robots hold a place, and how many are under way."""
        modes = list(self.covering.modes.values())
        under_way = modes.count(CoverageMode.TRAVELING)
        gathering = modes.count(CoverageMode.GATHERING)
        rest = f"{gathering} gathering" if gathering else f"{under_way} under way"
        return f"{modes.count(CoverageMode.HOLDING):3d} of {len(modes)} robots at their places, {rest}"

    def interrupted(self, time: float) -> Verdict:
        """Return the verdict of a run that the operator ended at `time` [s]."""
        return Verdict(False, f"interrupted by the operator at {time:.1f} s: {self._tally()}")

    def unfinished(self, time: float) -> Verdict:
        """Return the verdict that is on disk while the run goes on, at `time` [s]."""
        return Verdict(False, f"still running at {time:.1f} s: {self._tally()}")

    def metrics(self, engine: str, verdict: Verdict, timing: Timing) -> Metrics:
        """Evaluate the run, finished or not."""
        quality = self.quality()
        values = self._common(engine, verdict, timing) | self._of_family(quality)
        return Metrics(values, tuple(_rows(values)))

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Return what ``trajectories.npz`` holds.

        ``time`` (t + 1,), ``position`` (t + 1, n, 3); ticks: ``tick_time`` (t,), ``alive`` (t, n), ``mode`` (t, n), -1
        where nothing was reported; what its values mean from 0 on, ``mode_names``; ``period`` (); ``link_range`` ();
        points on the shape where it is in the end, ``surface_points`` (k, 3); on every shape where it is at first,
        ``surfaces`` (s, k, 3), from which tick on it holds, ``surface_tick`` (s,), and how far it has moved,
        ``surface_shift`` (t, 3); now and then, at ``covered_time`` (c,), which share of it is covered by robots
        at their places, ``covered_share`` (c,); and what `Chronicle` tells.
        """
        count, truths = self._scenario.robots.count, self._truths
        times = np.array([truth.time for truth in truths])
        ends = [truth.ends for truth in truths]
        starts = [truth.positions for truth in truths[:1]]
        return {
            "time": np.append(times, times[-1:] + self._period),
            "position": np.array([*starts, *ends]).reshape(-1, count, 3),
            "tick_time": times,
            "alive": np.array([truth.alive for truth in truths], dtype=bool).reshape(-1, count),
            "mode": np.array(self._modes, dtype=np.int64).reshape(-1, count),
            "mode_names": np.array([mode.name.lower() for mode in CoverageMode]),
            "period": np.array(self._period),
            "link_range": np.array(self._scenario.agent.range_m),
            "surface_points": self.shape_points(),
            "surfaces": np.array([probe.surface for _, _, probe in self._probes]).reshape(-1, SURFACE_POINTS, 3),
            "surface_tick": np.array([tick for tick, _, _ in self._probes], dtype=np.int32),
            "surface_shift": np.array(self._shifts).reshape(-1, 3),
            "covered_time": np.array([time for time, _ in self._covered]),
            "covered_share": np.array([share for _, share in self._covered]),
            **self._chronicle.arrays(),
        }

    def figure(self, metrics: Metrics) -> bytes:
        """Return the picture of the run as PNG."""
        # Drawing takes a second to import; a run that was interrupted has no time for it.
        from bringup.coverage.figure import run_figure  # noqa: PLC0415

        return run_figure(self.arrays(), self.covering.holders, self.shape_points(), metrics)

    def quality(self) -> CoverageQuality | None:
        """Return how well the robots that hold places cover the shape in force, None if nobody does."""
        holders = self.covering.holders
        if not holders:
            return None
        success = self._scenario.success
        probe = CoverageProbe(solid_from(self._shape), self._scenario.agent.range_m, PROBE_SEED, success.probes)
        return probe.measure(self.covering.positions[holders] - self._shift())

    def _note_shape(self, tick: int) -> None:
        """Take note of which shape is in force, and where: with nobody at a place, where it was."""
        shape = self._shape
        if not self._probes or self._probes[-1][1] is not shape:
            reach = self._scenario.agent.range_m
            probe = CoverageProbe(solid_from(shape), reach, PROBE_SEED, COVERED_PROBES, SURFACE_POINTS)
            self._probes.append((tick, shape, probe))
        if self.covering.holders or not self._shifts:
            self._shifts.append(self._shift())
        else:
            self._shifts.append(self._shifts[-1])

    def _covered_share(self) -> float:
        """Return roughly how much of the shape in force the robots at their places cover."""
        holders = self.covering.holders
        if not holders:
            return 0.0
        return self._probes[-1][2].measure(self.covering.positions[holders] - self._shift()).covered_fraction

    def shape_points(self) -> FloatArray:
        """Return points on the surface of the shape, where it is now, (k, 3) [m]."""
        return CoverageProbe(solid_from(self._shape), 1.0, PROBE_SEED, 10, SURFACE_POINTS).surface + self._shift()

    @property
    def _shape(self) -> dict[str, Any]:
        """Description of the shape that was ordered last."""
        specs = [self._scenario.shape, *(event.shape for event in self._events[: self._passed] if event.shape)]
        solid = specs[-1].solid
        assert solid is not None  # a resolved scenario has its shapes written out
        return solid

    @property
    def _hold(self) -> float:
        return self._scenario.success.hold_s

    @property
    def _end_of_events(self) -> float:
        return max((event.at_s for event in self._events), default=0.0)

    def _shift(self) -> FloatArray:
        """Return how far the formation has moved, shape included, (3,) [m]; zero if it was never told to."""
        if not any(event.velocity_mps for event in self._events[: self._passed]):
            return np.zeros(3)
        return self.covering.shift()

    def _note_events(self, record: CoverageRecord) -> None:
        while self._passed < len(self._events) and self._events[self._passed].at_s <= record.truth.time + 1e-9:
            self._passed += 1
            self.covering.expect(self._scenario.agent.protocol.absence_ticks)

    def _judged(self) -> Verdict:
        """Return the verdict on a swarm with nothing left to do."""
        quality = self.quality()
        share = 0.0 if quality is None else quality.covered_fraction
        needed = self._scenario.success.covered_fraction_min
        if self.covering.components > 1:
            return Verdict(False, f"the swarm is in {self.covering.components} pieces: {self._tally()}")
        if share < needed:
            return Verdict(
                False,
                f"covered {share:.5f} of the shape, {needed:g} must be (success.covered_fraction_min); {self._tally()}",
            )
        return Verdict(True, f"covered {share:.5f} of the shape: {self._tally()}")

    def _tally(self) -> str:
        lost = len(self._lost - {MISSION})
        dead = f", {lost} lost" if lost else ""
        waiting = list(self.covering.modes.values()).count(CoverageMode.WAITING)
        return f"{len(self.covering.holders)} robots hold places, {waiting} wait{dead}"

    def _common(self, engine: str, verdict: Verdict, timing: Timing) -> dict[str, Any]:
        """Return what all families tell; point robots have no bodies to collide."""
        errors = self.covering.errors(self._scenario.agent.range_m, self._shift()).localization
        return run_numbers(self._scenario, self._truths, engine, verdict, timing) | {
            "method": self._scenario.method,
            "physics": "points",
            "settling_time_s": self._period * self.covering.placed_at if self.covering.is_over else None,
            "localization_rmse_m": float(np.sqrt(np.mean(errors**2))) if len(errors) else None,
            "localization_max_m": float(errors.max()) if len(errors) else None,
            "lost_robots": len(self._lost - {MISSION}),
        }

    def _of_family(self, quality: CoverageQuality | None) -> dict[str, Any]:
        covering = self.covering
        rendezvous, approach, expansion = covering.times_s
        errors = covering.errors(self._scenario.agent.range_m, self._shift())
        count = len(errors.placement)
        return {
            "placed_robots": len(covering.holders),
            "covered_fraction": quality.covered_fraction if quality else None,
            "connected_fraction_of_ticks": covering.connected_fraction,
            "rendezvous_time_s": rendezvous,
            "expansion_time_s": expansion,
            "approach_time_s": approach,
            "covered_error": quality.covered_error if quality else None,
            "boundary_fraction": quality.boundary_fraction if quality else None,
            "worst_gap_m": quality.worst_gap_m if quality else None,
            "disconnected_ticks": covering.violations,
            "components": covering.components,
            "placement_rmse_m": float(np.sqrt(np.mean(errors.placement**2))) if count else None,
            "placement_max_m": float(errors.placement.max()) if count else None,
            "link_m": self._scenario.agent.range_m,
            "depth_max": int(errors.depths.max()) if count else None,
        }


def _rows(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what the operator reads of the numbers."""
    covered, gap = _number(values["covered_fraction"], "", 5), _number(values["worst_gap_m"], "m")
    placed = f"{values['placed_robots']} of {values['robots']}"
    if values["depth_max"] is not None:
        placed += f", deepest {values['depth_max']} links from the leader"
    times = ", ".join(
        f"{stage} {_number(values[f'{stage}_time_s'], 's', 0)}" for stage in ("rendezvous", "approach", "expansion")
    )
    traffic = f"{values['radio_bytes'] / 1e6:.2f} MB in {values['radio_frames']} frames"
    peak = f"peak {values['radio_neighborhood_peak_bps'] / 1e3:.0f} kbit/s in a neighborhood"
    return [
        ("covered", f"{covered} of the volume, worst gap {gap}"),
        ("robots at places", placed),
        ("times", times),
        ("connected", f"{values['disconnected_ticks']} of {values['ticks']} ticks in pieces"),
        ("localization error", f"{_number(values['localization_rmse_m'], 'm', 3)} rms"),
        ("radio", f"{traffic}, {peak}"),
        (
            "speed",
            f"{_number(values['real_time_factor'], 'x real time')}, start-up {_number(values['startup_s'], 's')}",
        ),
    ]


def _number(value: float | None, unit: str, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()
