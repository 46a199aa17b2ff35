"""What is to be seen of docking boats while they go on."""

from __future__ import annotations

import numpy as np

from bringup import scene
from bringup.assembly.planning import planned
from bringup.assembly.scenario import AssemblyScenario
from bringup.engine import TickRecord
from bringup.scene import RobotView, Scene
from swarm_msgs_py.assembly.boat_io import AssemblyReport, BoatMode
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.boats.bodies import Latch
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.simulation import PoolTruth

COLUMNS = ("plan", "step", "of", "docks", "error [m]")
COLORS = {
    BoatMode.IDLE: scene.IDLE,
    BoatMode.WAITING: scene.HELD_UP,
    BoatMode.MOVING: scene.MOVING,
    BoatMode.DOCKED: scene.RESTING,
}
CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


class AssemblyScenes:
    """Implements `bringup.scene.Scenes`; links are docks, outlines the cells of the structure.

    Parameters
    ----------
    scenario : AssemblyScenario
        Resolved.
    """

    columns = COLUMNS

    def __init__(self, scenario: AssemblyScenario) -> None:
        problem = planned(scenario).problem
        self.radii: FloatArray = np.full(scenario.boats, scenario.sim.boats.hull.side_m / 2.0)
        self.walls = _cells(problem.obstacles)
        self._targets = _cells(problem.targets)
        self._places: FloatArray = CELL_M * np.array(problem.targets, dtype=np.float64).reshape(-1, 2)
        self._latches: set[Latch] = set()

    def take(self, record: TickRecord[PoolTruth, AssemblyReport]) -> Scene:
        """Take in one tick, and return how things are in it."""
        truth = record.truth
        for event in truth.events:
            (self._latches.add if event.holds else self._latches.discard)(event.latch)
        docks = [end for latch in self._latches for end in (latch.boat, latch.other)]
        robots = tuple(
            _view(
                NodeId(row),
                record.reports.get(NodeId(row)),
                truth.positions[row],
                docks.count(row),
                is_alive=bool(is_alive),
            )
            for row, is_alive in enumerate(truth.alive)
        )
        links = tuple(sorted((latch.boat, latch.other) for latch in self._latches))
        return Scene(robots, truth.positions, links, self._places, self._targets)


def _view(robot: NodeId, report: AssemblyReport | None, place: FloatArray, docks: int, *, is_alive: bool) -> RobotView:
    if report is None or not is_alive:
        return scene.absent(robot, COLUMNS, is_alive=is_alive)
    is_done = report.mode in (BoatMode.DOCKED, BoatMode.IDLE)
    left = float(report.steps - report.steps_done)
    error = float(np.hypot(*(report.pose[:2] - place)))
    facts = (report.epoch, report.steps_done, report.steps, docks, error)
    need = scene.WELL if is_done else scene.UNDER_WAY
    return RobotView(robot, report.mode.name.lower(), COLORS[report.mode], (need, -left), facts)


def _cells(cells: tuple[tuple[int, int], ...]) -> tuple[FloatArray, ...]:
    """Return the outline of each cell, (4, 2) [m]."""
    return tuple(CELL_M * (np.array(cell) + CORNERS) for cell in cells)
