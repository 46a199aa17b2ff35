"""What is to be seen of a formation while it goes on.

Goal distances and localization errors are the true ones, which only an onlooker knows.
"""

from __future__ import annotations

import numpy as np

from bringup import scene
from bringup.engine import FormationRecord
from bringup.history import heard_pairs
from bringup.layout import robot_types, walls
from bringup.scenario import Scenario
from bringup.scene import RobotView, Scene
from swarm_msgs_py.messages.report import AgentReport, Mode, Positioning
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import contour_at, goals_at
from swarm_msgs_py.types import FloatArray, NodeId

COLUMNS = ("position", "goal", "to goal [m]", "error [m]", "sigma [m]", "links", "beacons", "routes")
COLORS = {
    Mode.PARKED: scene.RESTING,
    Mode.TRAVELING: scene.MOVING,
    Mode.BLOCKED: scene.HELD_UP,
    Mode.RETURN_HOME: scene.ASTRAY,
    Mode.SEARCHING: scene.ASTRAY,
    Mode.UNASSIGNED: scene.IDLE,
    Mode.WAITING: scene.UNREADY,
    Mode.BLIND: scene.ASTRAY,
}


class FormationScenes:
    """Implements `bringup.scene.Scenes`.

    Parameters
    ----------
    scenario : Scenario
        Resolved.
    """

    columns = COLUMNS

    def __init__(self, scenario: Scenario) -> None:
        self.radii: FloatArray = np.array([kind.coverage_radius_m for kind in robot_types(scenario)])
        self.walls = tuple(walls(scenario))
        self._course = Course()

    def take(self, record: FormationRecord) -> Scene:
        """Take in one tick, and return how things are in it."""
        if record.plan is not None:
            self._course.put(record.tick, record.plan)
        goals: FloatArray = np.empty((0, 2))
        outlines: tuple[FloatArray, ...] = ()
        if self._course.plans:
            plan = self._course.at(record.tick)
            goals, outlines = goals_at(plan, record.tick), (contour_at(plan, record.tick),)
        positions = record.truth.positions
        robots = tuple(
            _view(NodeId(row), record.reports.get(NodeId(row)), positions[row], goals, is_alive=bool(is_alive))
            for row, is_alive in enumerate(record.truth.alive)
        )
        links = tuple(pair for pair in sorted(heard_pairs(record)) if max(pair) < len(robots))
        return Scene(robots, positions, links, goals, outlines)


def _view(
    robot: NodeId, report: AgentReport | None, place: FloatArray, goals: FloatArray, *, is_alive: bool
) -> RobotView:
    if report is None or not is_alive:
        return scene.absent(robot, COLUMNS, is_alive=is_alive)
    has_goal = 0 <= report.goal < len(goals)
    distance = float(np.hypot(*(goals[report.goal] - place))) if has_goal else None
    error = float(np.hypot(*(report.position - place))) if report.mode is not Mode.WAITING else None
    positioning = report.localization.positioning
    is_lost, is_parked = positioning is not Positioning.LOCALIZED, report.mode is Mode.PARKED
    need = scene.ALARM if is_lost else scene.WELL if is_parked else scene.UNDER_WAY
    facts = (
        positioning.name.lower().replace("_", " "),
        report.goal if report.goal >= 0 else None,
        distance,
        error,
        float(np.sqrt(np.trace(report.covariance) / 2.0)),
        len(report.neighbors),
        report.beacons,
        report.routes,
    )
    state = report.mode.name.lower().replace("_", " ")
    return RobotView(robot, state, COLORS[report.mode], (need, -(distance or 0.0)), facts)
