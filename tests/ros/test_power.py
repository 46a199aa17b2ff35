"""Robots are switched off and on while a run goes on: by the scenario, and by the operator's services."""

from __future__ import annotations

from itertools import islice
from typing import Any

import pytest
from ros_harness import Overseer, RosHarness, harness
from std_srvs.srv import SetBool
from swarms import PERIOD, SmallSwarm

from bringup.inprocess import InProcessEngine
from bringup.ros_engine import RosEngine
from swarm_msgs_py import topics
from swarm_msgs_py.types import NodeId
from swarm_sim.ros.lockstep import Lockstep, PaceConfig
from swarm_sim.ros.world_node import WorldNode


@pytest.mark.usefixtures("nothing_left")
def test_robots_that_are_added_do_the_same_as_without_ros() -> None:
    swarm = SmallSwarm(4, deaths=((NodeId(2), 3),), arrivals=((NodeId(2), 9), (NodeId(1), 6)))
    with RosEngine(swarm, agents_per_process=2) as engine:
        records = list(islice(engine.ticks(), 16))
    with InProcessEngine(swarm) as reference:
        expected = list(islice(reference.ticks(), 16))

    for record, wanted in zip(records, expected, strict=True):
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert list(record.reports) == list(wanted.reports)
        assert (record.alerts, record.lost) == (wanted.alerts, wanted.lost)
    assert [sorted(record.lost) for record in (records[0], records[5], records[8], records[9])] == [
        [1],
        [1, 2],
        [2],
        [],
    ]
    assert records[9].alerts == ("r02 is switched on, as the scenario says",)
    assert list(records[15].reports) == [0, 1, 2, 3]


@pytest.mark.usefixtures("domain_id")
def test_the_operator_kills_a_robot_and_switches_it_on_again() -> None:
    swarm = SmallSwarm(2)
    simulation = swarm.simulation()
    with harness() as ros:
        world = ros.add(WorldNode(simulation, PERIOD, context=ros.context))
        overseer = Overseer(ticks=1)
        lockstep = Lockstep(world, ros.executor, PaceConfig(first_deadline_s=0.01, deadline_s=0.01), overseer)

        def power(robot: int, is_on: bool) -> Any:
            return call(ros, topics.power_service(NodeId(robot)), SetBool.Request(data=is_on))

        killed, again = power(1, False), power(1, False)
        lockstep.run_tick()
        back, twice = power(1, True), power(1, True)
        lockstep.run_tick()
        world.bury(NodeId(0))
        gone = power(0, True)

    assert [reply.success for reply in (killed, again, back, twice, gone)] == [True, False, True, False, False]
    assert again.message == "r01 is off already"
    assert gone.message == "the process of r00 is gone; start the run again"
    first, second = overseer.results
    assert (first.alerts[0], sorted(first.lost)) == ("r01 was killed by the operator", [1])
    assert (second.alerts[0], sorted(second.lost)) == ("r01 was switched on by the operator", [])
    assert [truth.alive.tolist() for truth in (first.truth, second.truth)] == [[True, False], [True, True]]
    simulation.close()


@pytest.mark.usefixtures("domain_id")
def test_a_robot_in_reserve_whose_process_is_gone_never_arrives() -> None:
    swarm = SmallSwarm(2, arrivals=((NodeId(1), 2),))
    simulation = swarm.simulation()
    with harness() as ros:
        world = ros.add(WorldNode(simulation, PERIOD, context=ros.context))
        overseer = Overseer(ticks=4, dead=(NodeId(1),))
        pace = PaceConfig(first_deadline_s=0.01, deadline_s=0.01)
        lockstep = Lockstep(world, ros.executor, pace, overseer)
        for _ in range(4):
            lockstep.run_tick()

    assert [result.truth.alive.tolist() for result in overseer.results] == [[True, False]] * 4
    assert all(1 in result.lost for result in overseer.results)
    simulation.close()


def call(ros: RosHarness, name: str, request: Any) -> Any:
    """Call a service of a node in this process."""
    client = ros.probe.create_client(SetBool, name)
    ros.wait(client.service_is_ready, name)
    reply = client.call_async(request)
    ros.wait(reply.done, f"a reply of {name}")
    return reply.result()
