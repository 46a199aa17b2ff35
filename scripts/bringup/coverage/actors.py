"""A resolved coverage scenario becomes actors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bringup.alike_actors import AlikeActors
from bringup.coverage.scenario import CoverageScenario
from bringup.coverage.starts import LEADER, start_positions
from bringup.scenario import tick_from
from mission_computer.order_desk import OrderDesk
from swarm_agent.coverage.agent import CoverageAgent
from swarm_msgs_py.coverage_orders import AT_REST, CoverageOrder
from swarm_msgs_py.geometry.solids.barriers import Barriers
from swarm_msgs_py.geometry.solids.description import packed_description, solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import NodeId
from swarm_sim.points.simulation import PointScene, PointSimulation

SEEDS = 2**31  # of the robots' lots


@dataclass(frozen=True, slots=True, eq=False)
class CoverageActors(AlikeActors[CoverageScenario]):
    """The actors of one resolved scenario; implements `bringup.engine.Actors`.

    Attributes
    ----------
    scene : PointScene
        Who is where at the start; made once, before the processes part.
    lots : int
        Seed of what the robots draw: one that says nothing of the world's.
    """

    scene: PointScene = field(init=False)
    lots: int = field(init=False)

    def __post_init__(self) -> None:
        """Place everything."""
        object.__setattr__(self, "scene", make_scene(self.scenario))
        object.__setattr__(self, "lots", int(rng_for(self.scenario.seed, "coverage", "lots").integers(SEEDS)))

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
            self.scenario.agent,
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
