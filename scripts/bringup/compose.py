"""Composition root: a resolved scenario becomes actors."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from bringup.layout import make_scene, markers, rally_point, robot_types, told_start
from bringup.resolution import contour_of, network_of, stages_of
from bringup.scenario import Scenario
from bringup.staging import heading_of
from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_agent.localization.config import LpsMode
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import NodeId
from swarm_sim.config import RangingModel, SimConfig
from swarm_sim.scene import Scene
from swarm_sim.simulation import Simulation

SIGMA_MIN_M = 0.01
"""Noise that robots reckon with where the world's ranges have none: a filter that is sure of everything is never put
right."""


@dataclass(frozen=True, slots=True, eq=False)
class ScenarioActors:
    """The actors of one resolved scenario; implements `bringup.engine.Actors`.

    Attributes
    ----------
    scenario : Scenario
    scene : Scene
        What stands where at the start; made once, before the processes part.
    """

    scenario: Scenario
    scene: Scene = field(init=False)

    def __post_init__(self) -> None:
        """Place everything."""
        object.__setattr__(self, "scene", make_scene(self.scenario))

    @property
    def family(self) -> str:
        """Name of the family of behavior."""
        return self.scenario.family.value

    @property
    def robots(self) -> tuple[NodeId, ...]:
        """All robots, ascending."""
        return tuple(NodeId(robot) for robot in range(self.scenario.robots.count))

    @property
    def period_s(self) -> float:
        """Control period [s]."""
        return self.scenario.sim.period_s

    @property
    def image_hz(self) -> float | None:
        """How many images a second an overhead camera takes; None without one."""
        camera = self.scenario.sim.camera
        return camera.rate_hz if camera.is_on else None

    @property
    def world_config(self) -> SimConfig:
        """Settings of the world; it ranges as often and as robots localize unless the scenario says otherwise."""
        sim, lps = self.scenario.sim, self.scenario.agent.lps
        ranging = sim.ranging
        if ranging.period_s is None:
            ranging = replace(ranging, period_s=lps.period_s)
        if ranging.model is None:
            is_literal = lps.mode is LpsMode.LITERAL
            ranging = replace(ranging, model=RangingModel.POSITION if is_literal else RangingModel.RANGE)
        return replace(sim, ranging=ranging)

    @property
    def mission_config(self) -> MissionConfig:
        """Settings of the mission computer; it knows how fast robots drive unless the scenario says otherwise."""
        mission = self.scenario.mission
        if mission.robot_speed_m_s is not None:
            return mission
        return replace(mission, robot_speed_m_s=self.scenario.agent.control.speed_max_m_s)

    def agent_config(self, robot: NodeId) -> AgentConfig:
        """Return the settings of one robot: what the scenario says of all, and of this one.

        It rallies at the mission computer unless the scenario says where. It knows how noisy the world's ranges are,
        unless the scenario has it believe something else. Its network bears what the scenario's radio does, as that of
        the mission computer.
        """
        agent, robots = self.scenario.agent, self.scenario.robots
        decision, energy = replace(agent.decision, rally_point_m=rally_point(self.scenario)), agent.energy
        if robots.priorities is not None:
            decision = replace(decision, weight=replace(decision.weight, priority=robots.priorities[robot]))
        if robots.energies is not None:
            energy = replace(energy, initial=robots.energies[robot])
        lps, sigma = agent.lps, max(self.scenario.sim.ranging.sigma_m, SIGMA_MIN_M)
        lps = replace(
            lps,
            range_sigma_m=sigma if lps.range_sigma_m is None else lps.range_sigma_m,
            position_noise_sigma_m=sigma if lps.position_noise_sigma_m is None else lps.position_noise_sigma_m,
        )
        return replace(agent, decision=decision, energy=energy, lps=lps, network=network_of(self.scenario))

    def simulation(self) -> Simulation:
        """Make the world at tick 0."""
        return Simulation(
            self.world_config, self.scene, self.scenario.seed, self.scenario.deaths, self.scenario.arrivals
        )

    def mission(self) -> Mission:
        """Make the mission computer; it is ordered the scenario's shapes."""
        return Mission(
            self.mission_config,
            network_of(self.scenario),
            Roster.of(robot_types(self.scenario)),
            self.scene.obstacles,
            contour_of(self.scenario),
            self.period_s,
            self.scene.bounds,
            stages_of(self.scenario),
            markers(self.scenario),
            heading_of(self.scenario.shape),
        )

    def agent(self, robot: NodeId) -> Agent:
        """Make one robot's agent. The operator tells it the map, roughly its start point, and how to partition."""
        kind = self.scene.robots[robot].type
        start = told_start(self.scenario, self.scene, robot)
        tuning = self.scenario.mission.partition
        return Agent(robot, self.agent_config(robot), kind, self.period_s, self.scene.obstacles, start, tuning)
