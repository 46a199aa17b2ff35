"""Two rooms and a corridor too narrow for two robots: agents, radio and bodies, with a plan given by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from arena import make_config, make_robot, rectangle

from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.messages.report import AgentReport
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId
from swarm_sim.config import RadioConfig
from swarm_sim.scene import Scene
from swarm_sim.simulation import Simulation

PERIOD = 0.5
SMALL = THESIS_TYPES[0]  # 0.3 m across
HALF_WIDTH = 0.3  # of the corridor: two small robots would touch each other and the walls
LENGTH = 6.0
WALLS = (
    rectangle(-LENGTH / 2, HALF_WIDTH, LENGTH / 2, 9.0),
    rectangle(-LENGTH / 2, -9.0, LENGTH / 2, -HALF_WIDTH),
    rectangle(-9.0, 2.0, 9.0, 9.0),
    rectangle(-9.0, -9.0, 9.0, -2.0),
    rectangle(-9.0, -2.0, -8.0, 2.0),
    rectangle(8.0, -2.0, 9.0, 2.0),
)
Points = Sequence[tuple[float, float]]


class PlanGiver:
    """Stands in for the mission computer: a radio that floods one plan until everybody shows it."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._mesh = MeshNetwork(MISSION, NetworkConfig(), PERIOD)

    def step(self, inputs: MissionInputs, robots: int) -> tuple[bytes, ...]:
        self._mesh.receive(inputs.tick, inputs.inbox)
        informed = sum(presence.epoch == self._plan.epoch for presence in self._mesh.neighbors.values())
        if inputs.tick % 4 == 2 and informed < robots:
            self._mesh.flood(encode_body(self._plan))
        nowhere = np.zeros(2)
        presence = Presence(
            nowhere, nowhere, np.eye(2) * SIGMA_UNKNOWN**2, 0.0, inputs.tick, 0, False, 0, self._plan.epoch, 0
        )
        return self._mesh.transmit(inputs.tick, presence)


class Corridor:
    """A run; robots know their places, and the numbers of robots and goals are equal.

    Parameters
    ----------
    starts, goals : sequence of (x, y)
        One per robot [m].
    configs : sequence of AgentConfig
        One per robot.
    loss : float
        Share of frames that the radio loses.
    """

    def __init__(self, starts: Points, goals: Points, configs: Sequence[AgentConfig], loss: float = 0.0) -> None:
        robots = tuple(make_robot(number, start, SMALL) for number, start in enumerate(starts))
        scene = Scene(robots, WALLS, (-9.0, -9.0, 9.0, 9.0), (0.0, 0.0))
        self.world = Simulation(make_config(radio=RadioConfig(loss=loss)), scene, seed=1)
        contour = np.array([[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]])
        plan = Plan(1, contour, WALLS, np.array(goals), np.ones(len(goals), dtype=np.int64))
        self._giver = PlanGiver(plan)
        self.goals = plan.goals
        self._agents = [Agent(NodeId(number), config, SMALL, PERIOD, WALLS) for number, config in enumerate(configs)]
        self.reports: list[AgentReport] = []
        self.positions: FloatArray = np.array(starts)
        self.overlaps: set[tuple[int, int]] = set()

    def run(self, seconds: float, remote: FloatArray | None = None) -> None:
        """Go on for a while; with `remote`, somebody drives the robots by hand at these velocities, (n, 2) [m/s]."""
        for _ in range(round(seconds / PERIOD)):
            seen = self.world.observe()
            outputs = {robot: self._agents[robot].step(inputs) for robot, inputs in seen.agents.items()}
            commands = {robot: output.command for robot, output in outputs.items()}
            if remote is not None:
                commands = {robot: VelocityCommand(*remote[robot], 0.0) for robot in commands}
            frames = {robot: output.outbox for robot, output in outputs.items()}
            self.world.apply(commands, {**frames, MISSION: self._giver.step(seen.mission, len(self._agents))})
            truth = self.world.advance()
            self.reports = [outputs[robot].report for robot in sorted(outputs)]
            self.positions = truth.samples[-1]
            if remote is None:
                self.overlaps |= set(truth.overlaps)

    def finish(self, limit: float) -> bool:
        """Go on until everybody has finished; return whether they have within this many seconds."""
        for _ in range(round(limit / PERIOD)):
            if self.has_finished:
                break
            self.run(PERIOD)
        return self.has_finished

    @property
    def taken(self) -> list[int]:
        """Goal of each robot."""
        return [report.goal for report in self.reports]

    @property
    def has_finished(self) -> bool:
        """Whether every robot stands at a goal of its own."""
        away = np.linalg.norm(self.positions - self.goals[self.taken], axis=1)
        return sorted(self.taken) == list(range(len(self.goals))) and bool((away < 0.2).all())
