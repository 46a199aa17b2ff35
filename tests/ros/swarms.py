"""Small swarms for tests of the ROS nodes: real worlds, agents and mission computers in an empty field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import NodeId
from swarm_sim.config import Backend, PhysicsConfig, SimConfig
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.simulation import Simulation

PERIOD = 0.5
SEED = 5
SQUARE = np.array([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]])
SMALL = THESIS_TYPES[0]


@dataclass(frozen=True)
class SmallSwarm:
    """`count` robots in a row, north of a square; implements `bringup.engine.Actors`.

    `deaths` are pairs of a robot, or `MISSION`, and the tick at which it dies, `arrivals` such at
    which it is switched on; `task` is what plans ask of the robots.
    """

    count: int
    deaths: tuple[tuple[NodeId, int], ...] = ()
    task: Task = Task.GOALS
    arrivals: tuple[tuple[NodeId, int], ...] = ()

    @property
    def family(self) -> str:
        return "formation"

    @property
    def robots(self) -> tuple[NodeId, ...]:
        return tuple(NodeId(number) for number in range(self.count))

    @property
    def period_s(self) -> float:
        return PERIOD

    @property
    def image_hz(self) -> float | None:
        return None

    @property
    def world_config(self) -> SimConfig:
        return SimConfig(physics=PhysicsConfig(backend=Backend.MASSDAMPER))

    @property
    def mission_config(self) -> MissionConfig:
        return MissionConfig(task=self.task)

    def agent_config(self, robot: NodeId) -> AgentConfig:  # noqa: ARG002 - all alike
        return AgentConfig()

    def simulation(self) -> Simulation:
        robots = tuple(
            RobotSpec(robot, SMALL, (1.5 * (robot - self.count / 2), 6.0), 0.1 * robot, True) for robot in self.robots
        )
        scene = Scene(robots, (), (-20.0, -20.0, 20.0, 20.0), (0.0, 0.0))
        return Simulation(self.world_config, scene, SEED, dict(self.deaths), dict(self.arrivals))

    def mission(self) -> Mission:
        roster = Roster.of([SMALL] * self.count)
        return Mission(self.mission_config, NetworkConfig(), roster, (), SQUARE, PERIOD)

    def agent(self, robot: NodeId) -> Agent:
        return Agent(robot, self.agent_config(robot), SMALL, PERIOD)
