"""What is noted of an assembly run, when it is over, and what its numbers are: from true states only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from bringup.assembly.planning import planned
from bringup.assembly.scenario import AssemblyScenario
from bringup.engine import TickRecord
from bringup.family import Metrics
from bringup.history import Chronicle, PairChanges, reported_modes
from bringup.run_numbers import run_numbers
from bringup.verdict import Timing, Verdict
from swarm_msgs_py.assembly.boat_io import AssemblyReport, BoatMode
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.boats.bodies import Latch
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.simulation import PoolTruth
from swarm_sim.metrics.docking import Standing, standing_of

AssemblyRecord = TickRecord[PoolTruth, AssemblyReport]
"""One tick of the assembly family."""

QUIET_S = 20.0
"""A swarm in which nobody moves for so long has done what it could [s]."""
STILL_M = 0.02
"""Boats that hold their places sway by less than this in a tick [m]."""


class AssemblyAccount:
    """Implements `bringup.family.Account`.

    Parameters
    ----------
    scenario : AssemblyScenario
        Resolved.
    """

    def __init__(self, scenario: AssemblyScenario) -> None:
        self._scenario = scenario
        self._period = scenario.sim.period_s
        self._mission = planned(scenario)
        self._truths: list[PoolTruth] = []
        self._latches: set[Latch] = set()
        self._torn = 0
        self._lost: frozenset[NodeId] = frozenset()
        self._steps = 0
        self._quiet_since = 0.0
        self._built_at: float | None = None
        self._notice = ""
        self._modes: list[np.ndarray] = []
        self._filled: list[int] = []
        self._docks, self._chronicle = PairChanges(), Chronicle()

    def take(self, record: AssemblyRecord) -> Verdict | None:
        """Take in one tick; return the verdict when there is one."""
        truth = record.truth
        self._truths.append(truth)
        self._lost = record.lost
        if record.mission is not None:
            self._notice = record.mission.notice
        for event in truth.events:
            self._torn += not event.holds
            (self._latches.add if event.holds else self._latches.discard)(event.latch)
        self._docks.put(record.tick, ((latch.boat, latch.other) for latch in self._latches))
        self._chronicle.take(record, ())
        self._modes.append(reported_modes(record))
        self._steps = max((self._steps, *(report.steps_done for report in record.reports.values())))
        end = truth.time + self._period
        if np.linalg.norm(truth.ends - truth.positions, axis=1).max() > STILL_M or truth.events:
            self._quiet_since = end
        standing = self.standing()
        self._filled.append(standing.filled)
        wanted = self._mission.problem.target_count
        if standing.filled == wanted:
            self._built_at = end
            if truth.overlaps:
                return Verdict(False, f"the structure stands, but {len(truth.overlaps)} pairs of hulls collided")
            return Verdict(True, f"all {wanted} boats of the structure hold together{_beside(standing)}")
        if not truth.alive.any():
            return Verdict(False, "all boats are lost; see the alerts for why")
        last_event = max((event.at_s for event in self._scenario.events), default=0.0)
        if end - max(self._quiet_since, last_event) > QUIET_S and self._steps > 0:
            return Verdict(False, f"nobody moves any more: {self._tally(standing)}")
        if end >= self._scenario.duration_s - 1e-9:
            return Verdict(False, f"time limit of {self._scenario.duration_s:g} s: {self._tally(standing)}")
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
        """How much of the structure stands."""
        standing = self.standing()
        return f"{standing.filled:3d} of {self._mission.problem.target_count} places filled, {standing.docks} docks"

    def standing(self) -> Standing:
        """Return what holds together now."""
        truth = self._truths[-1] if self._truths else None
        if truth is None:
            return Standing(0, (0, 0), 0, self._scenario.boats)
        return standing_of(self._mission.problem, truth.ends, self._latches)

    def interrupted(self, time: float) -> Verdict:
        """Return the verdict of a run that the operator ended at `time` [s]."""
        return Verdict(False, f"interrupted by the operator at {time:.1f} s: {self._tally(self.standing())}")

    def unfinished(self, time: float) -> Verdict:
        """Return the verdict that is on disk while the run goes on, at `time` [s]."""
        return Verdict(False, f"still running at {time:.1f} s: {self._tally(self.standing())}")

    def metrics(self, engine: str, verdict: Verdict, timing: Timing) -> Metrics:
        """Evaluate the run, finished or not."""
        values = self._common(engine, verdict, timing) | self._of_family()
        return Metrics(values, tuple(_rows(values)))

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Return what ``trajectories.npz`` holds.

        ``time`` (t + 1,), ``position`` (t + 1, n, 2); ticks: ``tick_time`` (t,), ``yaw`` (t, n), ``alive`` (t, n),
        ``mode`` (t, n), -1 where nothing was reported; what its values mean from 0 on, ``mode_names``;
        ``coverage_radius`` (n,): half the side of a hull; ``period`` (); ``latches`` (l, 2): who holds whom in the end;
        ``targets`` (m, 2): cells of the structure, with their centers in ``target_cells`` (m, 2) [m] and their edge in
        ``cell_size`` () [m]; docks over time as `PairChanges` has them, ``dock_*``; and what `Chronicle` tells.
        """
        count, truths = self._scenario.boats, self._truths
        times = np.array([truth.time for truth in truths])
        starts = [truth.positions for truth in truths[:1]]
        return {
            "time": np.append(times, times[-1:] + self._period),
            "position": np.array([*starts, *(truth.ends for truth in truths)]).reshape(-1, count, 2),
            "tick_time": times,
            "yaw": np.array([truth.yaws for truth in truths]).reshape(-1, count),
            "alive": np.array([truth.alive for truth in truths], dtype=bool).reshape(-1, count),
            "coverage_radius": np.full(count, self._scenario.sim.boats.hull.side_m / 2.0),
            "period": np.array(self._period),
            "latches": np.array(sorted((one.boat, one.other) for one in self._latches)).reshape(-1, 2),
            "mode": np.array(self._modes, dtype=np.int64).reshape(-1, count),
            "mode_names": np.array([mode.name.lower() for mode in BoatMode]),
            "targets": np.array(self._mission.problem.targets),
            "target_cells": CELL_M * np.array(self._mission.problem.targets, dtype=np.float64).reshape(-1, 2),
            "cell_size": np.array(CELL_M),
            "filled": np.array(self._filled, dtype=np.int64),
            **self._docks.arrays("dock"),
            **self._chronicle.arrays(),
        }

    def figure(self, metrics: Metrics) -> bytes:
        """Return the picture of the run as PNG."""
        # Drawing takes a second to import; a run that was interrupted has no time for it.
        from bringup.assembly.figure import run_figure  # noqa: PLC0415

        return run_figure(self.arrays(), metrics, self._scenario.sim.boats.hull.side_m)

    def _tally(self, standing: Standing) -> str:
        lost = len(self._lost - {MISSION})
        dead = f", {lost} lost" if lost else ""
        wanted = self._mission.problem.target_count
        why = f" ({self._notice})" if self._notice else ""
        return f"the largest group fills {standing.filled} of {wanted} places{dead}{why}"

    def _common(self, engine: str, verdict: Verdict, timing: Timing) -> dict[str, Any]:
        """Return what all families tell."""
        return run_numbers(self._scenario, self._truths, engine, verdict, timing) | {
            "method": self._scenario.navigation.value,
            "physics": self._scenario.sim.bodies.value,
            "settling_time_s": self._built_at,
            "collisions": len(self._truths[-1].overlaps) if self._truths else 0,
            "lost_robots": len(self._lost - {MISSION}),
        }

    def _of_family(self) -> dict[str, Any]:
        standing, mission = self.standing(), self._mission
        return {
            "steps": self._steps,
            "docked_edges": standing.docks,
            "components": standing.components,
            "feasible_solutions": mission.plan.feasible,
            "plan_wall_s": mission.wall_s,
            "filled_places": standing.filled,
            "shift_cells": list(standing.shift),
            "places": mission.problem.target_count,
            "docks_torn": self._torn,
            "thrust_energy_n2s": sum(truth.energy_n2s for truth in self._truths),
        }


def _beside(standing: Standing) -> str:
    if standing.shift == (0, 0):
        return ""
    return f", {standing.shift[0]} cells to the right and {standing.shift[1]} up of its place, where something lies"


def _rows(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what the operator reads of the numbers."""
    return [
        ("structure", f"{values['filled_places']} of {values['places']} places filled by one group"),
        ("docks", f"{values['docked_edges']} hold, {values['docks_torn']} came apart"),
        ("steps", f"{values['steps']}, planned in {values['plan_wall_s']:.1f} s"),
        ("time", f"{values['sim_time_s']:.1f} s, collisions {values['collisions']}"),
        ("thrust energy", f"{values['thrust_energy_n2s']:.0f} N^2 s"),
        ("radio", f"{values['radio_bytes'] / 1e3:.0f} kB in {values['radio_frames']} frames"),
    ]
