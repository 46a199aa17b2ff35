"""One robot's part in a formation by forces: from what it knows to the velocity that it wants."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from swarm_agent.forces.config import ForceConfig, ForceLawName
from swarm_agent.forces.force_drive import ForceDrive
from swarm_agent.forces.force_law import ForceLaw, Others
from swarm_agent.forces.registry import law_for
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, NodeId

_UNKNOWN = 0.99 * SIGMA_UNKNOWN  # [m]; who is less sure than this does not know where it is
_TICKS = 0xFFFF  # ticks are told modulo 2^16
_BELIEF = 8  # numbers in the belief of a presence, of which the first four are position and velocity
_NOTHING: FloatArray = np.empty(0)


class ForceStrategy:
    """Method A on one robot: no goals, no votes, no mission computer once the shape is known.

    Parameters
    ----------
    name : ForceLawName
        Law that drives the robot.
    config : ForceConfig
    planning : PlanningConfig
        How far paths keep from obstacles.
    robot_type : RobotType
        Of this robot.
    radii : mapping of int to float
        Coverage radius of each robot type of the swarm [m]; a type that is not there counts as this robot's own.
    period_s : float
        Control period [s].
    """

    def __init__(  # noqa: PLR0913, PLR0917 - a law, its settings, and who the robot is
        self,
        name: ForceLawName,
        config: ForceConfig,
        planning: PlanningConfig,
        robot_type: RobotType,
        radii: Mapping[int, float],
        period_s: float,
    ) -> None:
        self._name = name
        self._config = config.at_period(period_s)
        self._planning = planning
        self._radius = robot_type.coverage_radius_m
        self._radii = dict(radii)
        self._period = period_s
        self._drive = ForceDrive(self._config, period_s)
        self._contour: FloatArray | None = None
        self._obstacles: tuple[FloatArray, ...] = ()
        self._law: ForceLaw | None = None
        self._types: list[int] = []  # of the neighbors, in the order of their ids
        self._neighbor_radii: FloatArray = np.empty(0)  # of these types

    @property
    def is_at_rest(self) -> bool:
        """Whether the forces on the robot were too weak to move it when they were last asked for."""
        return bool(self._drive.resting[0])

    def step(  # noqa: PLR0913, PLR0917 - what a robot knows
        self,
        tick: int,
        position: FloatArray,
        neighbors: Mapping[NodeId, Presence],
        contour: FloatArray,
        obstacles: tuple[FloatArray, ...],
        sigma: float = 0.0,
    ) -> FloatArray:
        """Return the velocity that the forces ask for.

        Parameters
        ----------
        tick : int
        position : (2,) array
            Own estimate, world frame [m].
        neighbors : mapping of NodeId to Presence
            Latest hello of each radio in range. The mission computer, and robots that do not know where they are, do
            not count.
        contour : (k, 2) array
            Desired shape, simple and counter-clockwise [m].
        obstacles : tuple of (m, 2) array
            Outlines [m].
        sigma : float
            Standard deviation of the estimate, per axis [m]; who knows less rests sooner and starts again later.

        Returns
        -------
        (2,) array
            World frame, at most `speed_max_m_s` long [m/s]. Collision avoidance has the last word.
        """
        law = self._law_of(contour, obstacles)
        radius = np.array([self._radius])
        others, drifts = self._others(tick, neighbors)
        velocity: FloatArray = self._drive.step(law, position[None], radius, others, drifts, sigma)[0]
        return velocity

    def _law_of(self, contour: FloatArray, obstacles: tuple[FloatArray, ...]) -> ForceLaw:
        """Return the law of the shape and the map in force; looked up only when these are other ones."""
        if self._law is None or contour is not self._contour or obstacles is not self._obstacles:
            self._law = law_for(self._name, self._config, contour, obstacles, self._planning)
            self._contour, self._obstacles = contour, obstacles
        return self._law

    def _others(self, tick: int, neighbors: Mapping[NodeId, Presence]) -> tuple[Others, FloatArray]:
        """Return where the neighbors are by now, and their velocities, (m, 2) [m/s]."""
        heard = sorted(neighbors.items())
        robots = [presence for _, presence in heard if presence.robot_type and presence.sigma < _UNKNOWN]
        told = np.concatenate([_NOTHING, *[presence.belief for presence in robots]]).reshape(-1, _BELIEF)
        ages = (tick - np.array([presence.tick for presence in robots], dtype=np.int64)) & _TICKS
        drifts = told[:, 2:4]
        places = told[:, :2] + (ages * self._period)[:, None] * drifts
        radii = self._radii_of([presence.robot_type for presence in robots])
        return Others(places, radii, np.ones((1, len(robots)), dtype=np.bool_)), drifts

    def _radii_of(self, types: list[int]) -> FloatArray:
        """Return the coverage radii of robots of some types, (m,) [m]; the same neighbors are asked for every tick."""
        if types != self._types:
            self._types = types
            self._neighbor_radii = np.array([self._radii.get(robot_type, self._radius) for robot_type in types])
        return self._neighbor_radii
