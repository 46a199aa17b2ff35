from __future__ import annotations

import pytest

from bringup.resolution import resolve
from bringup.scenario_file import load_scenario, parse_assignment
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import NodeId
from swarm_sim.config import Backend, PhysicsConfig, SimConfig
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.simulation import Simulation


def simulation(deaths: dict[NodeId, int], arrivals: dict[NodeId, int]) -> Simulation:
    robots = tuple(RobotSpec(NodeId(k), THESIS_TYPES[0], (3.0 * k, 0.0), 0.0, True) for k in range(3))
    config = SimConfig(physics=PhysicsConfig(backend=Backend.MASSDAMPER))
    return Simulation(config, Scene(robots, (), (-20.0, -20.0, 20.0, 20.0), (0.0, 5.0)), 1, deaths, arrivals)


def test_who_comes_later_is_off_before_and_who_comes_back_is_off_between() -> None:
    sim = simulation({NodeId(1): 2}, {NodeId(1): 4, NodeId(2): 3})
    present = []
    for _ in range(6):
        present.append(tuple(sim.observe().agents))
        sim.advance()

    assert present == [(0, 1), (0, 1), (0,), (0, 2), (0, 1, 2), (0, 1, 2)]
    assert (sim.take_arrived(), sim.take_arrived()) == ((2, 1), ())
    assert all(map(sim.is_on, sim.robots))


def test_a_robot_that_is_switched_on_hears_and_is_heard() -> None:
    sim = simulation({}, {NodeId(2): 1})
    for _ in range(3):
        seen = sim.observe()
        sim.apply({}, {robot: (bytes([robot]),) for robot in seen.agents})
        sim.advance()
    seen = sim.observe()

    assert seen.agents[NodeId(2)].inbox == (b"\x00", b"\x01")
    assert b"\x02" in seen.agents[NodeId(0)].inbox
    assert len(seen.agents[NodeId(2)].ranges.neighbors) == 2


@pytest.mark.parametrize(
    ("events", "complaint"),
    [
        ("[{at_s: 5.0, add: [12]}]", r"events\[0\].add: there is no r12"),
        ("[{at_s: 5.0, add: [3]}, {at_s: 6.0, add: [3]}]", "r03 is added twice"),
        ("[{at_s: 5.0, add: [3]}, {at_s: 6.0, kill: [3]}]", "r03 is killed then, or later"),
    ],
)
def test_additions_that_cannot_happen_are_refused(events: str, complaint: str) -> None:
    with pytest.raises(ConfigError, match=complaint):
        resolve(*load_scenario("demo", (parse_assignment(f"events={events}"),)))
