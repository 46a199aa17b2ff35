"""A resolved assembly scenario becomes actors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bringup.alike_actors import AlikeActors
from bringup.assembly.planning import planned
from bringup.assembly.scenario import FACES, AssemblyScenario
from bringup.scenario import tick_from
from mission_computer.assembly.desk import AssemblyDesk
from swarm_agent.assembly.agent import AssemblyAgent
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.pool import Fleet
from swarm_sim.boats.simulation import BoatSimulation, PoolScene


@dataclass(frozen=True, slots=True, eq=False)
class AssemblyActors(AlikeActors[AssemblyScenario]):
    """The actors of one resolved scenario; implements `bringup.engine.Actors`."""

    def simulation(self) -> BoatSimulation:
        """Make the world at tick 0."""
        scenario, problem = self.scenario, planned(self.scenario).problem
        deaths = {node: tick_from(event.at_s, self.period_s) for event in scenario.events for node in event.dead}
        magnets = {
            (NodeId(magnet.boat), FACES[magnet.side]): tick_from(event.at_s, self.period_s)
            for event in scenario.events
            for magnet in event.magnets
        }
        fleet = Fleet(start_poses(problem), problem.layouts, problem.gender)
        return BoatSimulation(scenario.sim, PoolScene(fleet, middle(problem), magnets), scenario.seed, deaths)

    def mission(self) -> AssemblyDesk:
        """Make the mission computer, with its plan."""
        mission = planned(self.scenario)
        return AssemblyDesk(
            self.scenario.mission, mission.problem, mission.plan, self.scenario.seed, self.scenario.sim.period_s
        )

    def agent(self, robot: NodeId) -> AssemblyAgent:
        """Make one boat's agent."""
        return AssemblyAgent(robot, self.scenario.agent, self.period_s)


def start_poses(problem: AssemblyProblem) -> FloatArray:
    """Return where boats start (n, 3): at the centers of their cells, heading 0."""
    return np.column_stack([CELL_M * np.array(problem.starts, dtype=np.float64), np.zeros(problem.boat_count)])


def middle(problem: AssemblyProblem) -> FloatArray:
    """Return the middle of the pool (2,) [m]: there is the mission computer's antenna."""
    return np.asarray(CELL_M * (np.array(problem.origin) + 0.5 * (np.array(problem.size) - 1.0)))
