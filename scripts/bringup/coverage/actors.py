"""A resolved coverage scenario becomes actors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bringup.coverage.scenario import CoverageScenario
from bringup.coverage.starts import LEADER, start_positions
from bringup.scenario import tick_from
from mission_computer.order_desk import OrderConfig, OrderDesk
from swarm_agent.coverage.agent import CoverageAgent
from swarm_agent.coverage.config import CoverageConfig
from swarm_msgs_py.coverage_orders import AT_REST, CoverageOrder
from swarm_msgs_py.geometry.solids.barriers import Barriers
from swarm_msgs_py.geometry.solids.description import packed_description, solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import NodeId
from swarm_sim.points.config import PointSimConfig
from swarm_sim.points.simulation import PointScene, PointSimulation

SEEDS = 2**31  # of the robots' lots


@dataclass(frozen=True, slots=True, eq=False)
class CoverageActors:
    """The actors of one resolved scenario; implements `bringup.engine.Actors`.

    Attributes
    ----------
    scenario : CoverageScenario
    scene : PointScene
        Who is where at the start; made once, before the processes part.
    lots : int
        Seed of what the robots draw: one that says nothing of the world's.
    """

    scenario: CoverageScenario
    scene: PointScene = field(init=False)
    lots: int = field(init=False)

    def __post_init__(self) -> None:
        """Place everything."""
        object.__setattr__(self, "scene", make_scene(self.scenario))
        object.__setattr__(self, "lots", int(rng_for(self.scenario.seed, "coverage", "lots").integers(SEEDS)))

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
        return None

    @property
    def world_config(self) -> PointSimConfig:
        """Settings of the world."""
        return self.scenario.sim

    @property
    def mission_config(self) -> OrderConfig:
        """Settings of the mission computer."""
        return self.scenario.mission

    def agent_config(self, robot: NodeId) -> CoverageConfig:  # noqa: ARG002 - all alike
        """Return the settings of one robot."""
        return self.scenario.agent

    def simulation(self) -> PointSimulation:
        """Make the world at tick 0."""
        scenario = self.scenario
        deaths = {node: tick_from(event.at_s, self.period_s) for event in scenario.events for node in event.dead}
        return PointSimulation(scenario.sim, self.scene, scenario.seed, deaths)

    def mission(self) -> OrderDesk:
        """Make the mission computer; it radios the scenario's shapes and velocities to the leader."""
        return OrderDesk(self.scenario.mission, schedule_of(self.scenario))

    def agent(self, robot: NodeId) -> CoverageAgent:
        """Make one robot's agent. The operator tells it the obstacles; the leader alone hears where it is."""
        return CoverageAgent(
            robot,
            self.agent_config(robot),
            self.period_s,
            self.lots,
            is_leader=robot == LEADER,
            barriers=self.scene.barriers,
        )


def make_scene(scenario: CoverageScenario) -> PointScene:
    """Return who is where at the start of a resolved scenario."""
    robots = scenario.robots
    starts = start_positions(robots.count, scenario.agent.range_m, scenario.seed, robots.start_edge_m)
    arrivals = {
        NodeId(robot): tick_from(event.at_s, scenario.sim.period_s) for event in scenario.events for robot in event.join
    }
    barriers = Barriers([solid_from(data, f"obstacles[{number}]") for number, data in enumerate(scenario.obstacles)])
    antenna = np.array(scenario.mission.position_m)
    return PointScene(starts + np.array(robots.leader_m), LEADER, antenna, barriers, arrivals)


def schedule_of(scenario: CoverageScenario) -> list[tuple[int, CoverageOrder]]:
    """Return what the operator of a resolved scenario orders, and in which tick."""
    assert scenario.shape.solid is not None  # a resolved scenario has its shapes written out
    schedule = [(0, CoverageOrder(1, packed_description(scenario.shape.solid)))]
    orders = sorted((event for event in scenario.events if event.is_order), key=lambda event: event.at_s)
    for number, event in enumerate(orders, start=2):
        solid = event.shape.solid if event.shape is not None else None
        packed = b"" if solid is None else packed_description(solid)
        velocity = event.velocity_mps or AT_REST
        schedule.append((tick_from(event.at_s, scenario.sim.period_s), CoverageOrder(number, packed, velocity)))
    return schedule
