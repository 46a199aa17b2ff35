"""What is to be seen of a covering swarm while it goes on, in space."""

from __future__ import annotations

import numpy as np

from bringup import scene
from bringup.coverage.scenario import CoverageScenario
from bringup.engine import TickRecord
from bringup.scene import RobotView, Scene
from swarm_msgs_py.coverage_io import CoverageMode, CoverageReport
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.points.simulation import PointTruth

COLUMNS = ("to place [m]", "error [m]", "links", "hops", "places known")
SIZE = 0.05  # of robots that are points, in ranges of the radio
COLORS = {
    CoverageMode.GATHERING: scene.HELD_UP,
    CoverageMode.WAITING: scene.IDLE,
    CoverageMode.TRAVELING: scene.MOVING,
    CoverageMode.HOLDING: scene.RESTING,
}
FACES = (
    ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
    ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
    ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)),
    ((0, 1, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1)),
)
"""Faces of a box whose edges are all of its edges: 0 is the lower bound, 1 the upper."""


class CoverageScenes:
    """Implements `bringup.scene.Scenes`. Solids are shown as the boxes around them.

    Parameters
    ----------
    scenario : CoverageScenario
        Resolved.
    """

    columns = COLUMNS

    def __init__(self, scenario: CoverageScenario) -> None:
        self.radii: FloatArray = np.full(scenario.robots.count, SIZE * scenario.agent.range_m)
        self.walls = tuple(loop for data in scenario.obstacles for loop in _box(solid_from(data).bounds))
        self._shapes = [(event.at_s, event.shape.solid) for event in scenario.events if event.shape is not None]
        self._outlines = _box(solid_from(scenario.shape.solid or {}).bounds)

    def take(self, record: TickRecord[PointTruth, CoverageReport]) -> Scene:
        """Take in one tick, and return how things are in it."""
        truth = record.truth
        while self._shapes and self._shapes[0][0] <= truth.time:
            self._outlines = _box(solid_from(self._shapes.pop(0)[1] or {}).bounds)
        degrees = np.bincount(truth.links.ravel(), minlength=len(truth.alive))
        robots = tuple(
            _view(
                NodeId(row), record.reports.get(NodeId(row)), truth.positions[row], int(degrees[row]), is_alive=bool(on)
            )
            for row, on in enumerate(truth.alive)
        )
        places = [report.target for report in record.reports.values() if report.target is not None]
        links = tuple((int(one), int(other)) for one, other in truth.links)
        return Scene(robots, truth.positions, links, np.array(places).reshape(-1, 3), self._outlines)


def _view(robot: NodeId, report: CoverageReport | None, place: FloatArray, links: int, *, is_alive: bool) -> RobotView:
    if report is None or not is_alive:
        return scene.absent(robot, COLUMNS, is_alive=is_alive)
    distance = None if report.target is None else float(np.linalg.norm(report.target - place))
    error = None if report.position is None else float(np.linalg.norm(report.position - place))
    rests = report.mode in (CoverageMode.HOLDING, CoverageMode.WAITING)
    need = scene.ALARM if not links else scene.WELL if rests else scene.UNDER_WAY
    facts = (distance, error, links, report.hops if report.hops >= 0 else None, report.places)
    return RobotView(robot, report.mode.name.lower(), COLORS[report.mode], (need, -(distance or 0.0)), facts)


def _box(bounds: FloatArray) -> tuple[FloatArray, ...]:
    """Return loops along all edges of a box, given by its lower and upper corner, (2, 3) [m]."""
    return tuple(np.where(np.array(face, dtype=np.bool_), bounds[1], bounds[0]) for face in FACES)
