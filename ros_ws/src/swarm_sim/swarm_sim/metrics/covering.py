"""How a covering swarm gets on: its stages, its connection, who holds a place, and when nothing is left to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.coverage_io import CoverageMode, CoverageReport
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.metrics.coverage import live_components
from swarm_sim.points.simulation import PointTruth

SETTLED_TICKS = 8  # without anything left to do until a mission is over: news may still be on its way


@dataclass(frozen=True, slots=True, eq=False)
class CoveringErrors:
    """How far robots that hold places are from where they should be, and from where they believe to be [m].

    Attributes
    ----------
    placement, localization : (p,) array
        In the order of the robots' numbers.
    depths : (p,) int array
        Links to the leader over robots that hold places, -1 without a way.
    chains : (p,) int array
        Steps of localization from the leader: a robot is located by the nearest one that holds a place when it arrives,
        so that there may be more than links.
    """

    placement: FloatArray
    localization: FloatArray
    depths: np.ndarray
    chains: np.ndarray


class Covering:
    """Follows one run, tick by tick.

    Parameters
    ----------
    period_s : float
        Duration of a tick [s].

    Attributes
    ----------
    reports : mapping of NodeId to CoverageReport
        The last ones.
    modes : dict of NodeId to CoverageMode
        As reported last, of robots that live.
    components : int
        Into how many pieces strict links left the live robots at the beginning of the last tick.
    ticks, violations : int
        Ticks seen, and those in which the live robots were more than one piece.
    rendezvous_at, expanding_at, placed_at : int
        Ticks by which all had met, the leader had said what to do, and the last robot had taken its place.
    """

    def __init__(self, period_s: float) -> None:
        self._period = period_s
        self._done_for = 0
        self.reports: Mapping[NodeId, CoverageReport] = {}
        self._alive = np.zeros(0, dtype=np.bool_)
        self._chains: dict[NodeId, int] = {}
        self.positions: FloatArray = np.empty((0, 3))
        self.modes: dict[NodeId, CoverageMode] = {}
        self.components = self.ticks = self.violations = 0
        self.rendezvous_at = self.expanding_at = self.placed_at = 0

    def take(self, truth: PointTruth, reports: Mapping[NodeId, CoverageReport]) -> None:
        """Take in one tick."""
        self.ticks += 1
        self.components = live_components(truth.alive, truth.links)
        self.violations += self.components > 1
        modes = {robot: report.mode for robot, report in reports.items() if truth.alive[robot]}
        if CoverageMode.GATHERING in modes.values() and CoverageMode.HOLDING not in modes.values():
            self.rendezvous_at = self.ticks
        if not any(report.is_leading and report.mode is CoverageMode.HOLDING for report in reports.values()):
            self.expanding_at = max(self.expanding_at, self.ticks) if not self.placed_at else self.expanding_at
        before = {robot for robot, mode in self.modes.items() if mode is CoverageMode.HOLDING}
        newcomers = {robot for robot, mode in modes.items() if mode is CoverageMode.HOLDING} - before
        if newcomers:
            self.placed_at = self.ticks
            self._note_chains(sorted(newcomers), sorted(before & modes.keys()), truth.positions)
        self.modes, self.reports, self._alive, self.positions = modes, reports, truth.alive, truth.ends
        is_done = bool(modes) and all(reports[robot].is_done for robot in modes)
        self._done_for = self._done_for + 1 if is_done else 0

    def _note_chains(self, newcomers: list[NodeId], holders: list[NodeId], positions: FloatArray) -> None:
        """Note by how many steps robots are located that now hold places; nobody locates the first one."""
        for robot in newcomers:
            away = np.linalg.norm(positions[holders] - positions[robot], axis=1)
            self._chains[robot] = self._chains[holders[int(away.argmin())]] + 1 if holders else 0

    def expect(self, ticks: int = 0) -> None:
        """Count from anew when nothing is left to do, after something has happened that takes `ticks` to be noticed."""
        self._done_for = -ticks

    @property
    def is_over(self) -> bool:
        """Whether nothing has been left to do for some time."""
        return self._done_for >= SETTLED_TICKS

    @property
    def holders(self) -> list[NodeId]:
        """Who holds a place, ascending."""
        return sorted(robot for robot, mode in self.modes.items() if mode is CoverageMode.HOLDING)

    @property
    def connected_fraction(self) -> float | None:
        """Share of the ticks without violation; None before the first."""
        return 1.0 - self.violations / self.ticks if self.ticks else None

    @property
    def times_s(self) -> tuple[float, float, float]:
        """How long rendezvous, approach and expansion took [s]."""
        ends = (0, self.rendezvous_at, max(self.rendezvous_at, self.expanding_at))
        approach, expansion = ends[2] - ends[1], max(0, self.placed_at - ends[2])
        return self._period * ends[1], self._period * approach, self._period * expansion

    def shift(self) -> FloatArray:
        """Return how far the formation is from where its places were first, as the middle robot has it, (3,) [m]."""
        targets = [(robot, self.reports[robot].target) for robot in self.holders]
        shifts = [self.positions[robot] - target for robot, target in targets if target is not None]
        middle: FloatArray = np.median(np.array(shifts), axis=0) if shifts else np.zeros(3)
        return middle

    def errors(self, range_m: float, shift: FloatArray) -> CoveringErrors:
        """Return the errors of those who hold places.

        Parameters
        ----------
        range_m : float
            Links are shorter [m].
        shift : (3,) array
            How far the formation has moved [m]; places and beliefs are told without.
        """
        holders = self.holders
        true = self.positions[holders] - shift
        known = [self.reports[robot] for robot in holders]
        targets = np.array([report.target for report in known]).reshape(-1, 3)
        beliefs = np.array([report.position for report in known]).reshape(-1, 3)
        leading = [row for row, report in enumerate(known) if report.is_leading]
        return CoveringErrors(
            placement=np.linalg.norm(true - targets, axis=1),
            localization=np.linalg.norm(true - beliefs, axis=1),
            depths=_depths(true, leading[0] if leading else 0, range_m),
            chains=np.array([self._chains[robot] for robot in holders], dtype=np.int64),
        )


def _depths(positions: FloatArray, root: int, range_m: float) -> np.ndarray:
    """Return the hops of each robot from the `root`, (p,), -1 without a way."""
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    depths = np.full(len(positions), -1)
    reached, depth = np.arange(len(positions)) == root, 0
    while reached.any():
        depths[reached] = depth
        depth += 1
        reached = (distances[reached] < range_m).any(axis=0) & (depths < 0)
    return depths
