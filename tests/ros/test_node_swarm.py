"""A whole small swarm of nodes in one executor: same motion as without ROS, honest graph, nobody waits forever."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from geometry_msgs.msg import Point32, PolygonStamped
from rclpy.experimental.events_executor import EventsExecutor
from ros_harness import DEADLINE_S, Overseer, RosHarness, harness
from std_msgs.msg import UInt16
from std_srvs.srv import Trigger
from swarms import PERIOD, SmallSwarm

from bringup.inprocess import InProcessEngine
from mission_computer.ros.mission_node import MissionNode
from swarm_agent.ros.agent_node import AgentNode
from swarm_msgs_py import topics
from swarm_msgs_py.ros.spin import is_matched, spin_for
from swarm_msgs_py.types import MISSION, NodeId, robot_name
from swarm_sim.ros.lockstep import Lockstep, PaceConfig
from swarm_sim.ros.world_node import WorldNode

COUNT = 3
BRIEF = PaceConfig(deadline_s=0.5, first_deadline_s=0.5)
ENOUGH_LOOKS = 6  # of SLICE_S each, so more than the deadline
OPEN_TO_ALL = {"/clock", "/rosout", "/parameter_events"}


@dataclass
class LiveSwarm:
    ros: RosHarness
    world: WorldNode
    mission: MissionNode
    agents: dict[NodeId, AgentNode]
    steps: dict[NodeId, int]

    def run(self, ticks: int, pace: PaceConfig | None = None, dead: tuple[NodeId, ...] = ()) -> Overseer:
        overseer = Overseer(ticks, dead)
        Lockstep(self.world, self.ros.executor, pace or PaceConfig(), overseer).run()
        return overseer


@pytest.fixture
def swarm(domain_id: int) -> Iterator[LiveSwarm]:
    assert domain_id
    actors = SmallSwarm(COUNT)
    simulation = actors.simulation()
    with harness() as ros:
        world = ros.add(WorldNode(simulation, PERIOD, context=ros.context))
        mission = ros.add(MissionNode(actors.mission(), PERIOD, context=ros.context))
        steps = dict.fromkeys(actors.robots, 0)

        def count(robot: NodeId) -> None:
            steps[robot] += 1

        agents = {
            robot: ros.add(
                AgentNode(actors.agent(robot), robot, PERIOD, lambda _, r=robot: count(r), context=ros.context)  # type: ignore[misc]
            )
            for robot in actors.robots
        }
        nodes = [world, mission, *agents.values()]
        lockstep = {c.topic(r) for c in (*topics.ROBOT_SENSORS, *topics.ROBOT_ANSWERS) for r in actors.robots}
        lockstep |= {channel.topic(MISSION) for channel in topics.MISSION_CHANNELS}
        ros.wait(lambda: is_matched(nodes, lockstep.__contains__), "connections")
        yield LiveSwarm(ros, world, mission, agents, steps)
    simulation.close()


def test_the_nodes_move_the_robots_exactly_as_the_actors_do_without_ros(swarm: LiveSwarm) -> None:
    results = swarm.run(25).results

    with InProcessEngine(SmallSwarm(COUNT)) as engine:
        for result, record in zip(results, engine.ticks(), strict=False):
            assert result.truth.tick == record.tick
            assert result.truth.samples.tobytes() == record.truth.samples.tobytes()
            assert result.truth.yaws.tobytes() == record.truth.yaws.tobytes()
            assert result.truth.radio == record.truth.radio
    assert len(results) == 25
    assert np.abs(results[-1].truth.positions - results[0].truth.positions).max() > 1.0


def test_no_robot_listens_to_anything_outside_its_own_namespace(swarm: LiveSwarm) -> None:
    swarm.run(2)
    probe = swarm.ros.probe

    for robot, node in swarm.agents.items():
        name, namespace = node.get_name(), node.get_namespace()
        heard = {topic for topic, _ in probe.get_subscriber_names_and_types_by_node(name, namespace)}
        assert {channel.topic(robot) for channel in topics.ROBOT_SENSORS} <= heard
        assert {t for t in heard if not t.startswith(f"/{robot_name(robot)}/")} == set()
        assert not probe.get_client_names_and_types_by_node(name, namespace)


def test_no_robot_speaks_outside_its_own_namespace(swarm: LiveSwarm) -> None:
    swarm.run(2)

    for robot, node in swarm.agents.items():
        spoken = swarm.ros.probe.get_publisher_names_and_types_by_node(node.get_name(), node.get_namespace())
        assert {t for t, _ in spoken if not t.startswith(f"/{robot_name(robot)}/")} <= OPEN_TO_ALL


def test_every_topic_of_the_table_is_on_the_graph_with_its_type_and_no_other(swarm: LiveSwarm) -> None:
    swarm.run(2)

    live = {name: types for name, types in swarm.ros.probe.get_topic_names_and_types() if name not in OPEN_TO_ALL}

    declared = {name: [kind] for name, kind in topics.all_topics(tuple(swarm.agents)).items()}
    assert live == {name: types for name, types in declared.items() if name not in OPEN_TO_ALL}
    services = dict(swarm.ros.probe.get_service_names_and_types())
    assert services[topics.PAUSE_SERVICE] == services[topics.RESUME_SERVICE] == ["std_srvs/srv/Trigger"]


def test_every_topic_that_nodes_speak_on_carries_live_messages(swarm: LiveSwarm) -> None:
    robot = NodeId(1)
    heard = {channel: swarm.ros.listen(channel, robot) for channel in topics.ROBOT_CHANNELS}
    heard |= {channel: swarm.ros.listen(channel) for channel in (topics.CLOCK, topics.TRUTH)}
    heard |= {channel: swarm.ros.listen(channel) for channel in (topics.GOALS, topics.MARKERS)}
    ready = [channel.topic(robot if channel.is_per_node else None) for channel in heard]
    swarm.ros.wait(lambda: all(swarm.ros.probe.count_publishers(topic) for topic in ready), "publishers")

    def all_heard() -> bool:
        swarm.run(1)
        return all(heard.values())

    swarm.ros.wait(all_heard, "a message on every topic")
    assert len(heard[topics.GOALS][0].poses) == COUNT
    assert len(heard[topics.TRUTH][0].poses) == COUNT
    assert heard[topics.CLOCK][-1].clock.sec == swarm.world.tick // 2 - (swarm.world.tick % 2 == 0)


def test_an_operator_orders_a_new_shape_over_ros(swarm: LiveSwarm) -> None:
    swarm.run(2)
    goals = swarm.ros.listen(topics.GOALS)
    swarm.ros.wait(lambda: len(goals) == 1, "the latched goals of the first plan")
    corners = [(5.0, 5.0), (11.0, 5.0), (11.0, 11.0), (5.0, 11.0)]
    order = PolygonStamped()
    order.polygon.points = [Point32(x=x, y=y) for x, y in corners]

    swarm.ros.speaker(topics.SHAPE).publish(order)

    def is_planned() -> bool:
        swarm.run(1)
        return len(goals) == 2

    swarm.ros.wait(is_planned, "a second plan")
    assert all(5.0 < pose.position.x < 11.0 for pose in goals[1].poses)


def test_a_robot_that_does_not_answer_costs_one_deadline_and_is_named(swarm: LiveSwarm) -> None:
    swarm.run(2)
    mute = NodeId(1)
    swarm.ros.executor.remove_node(swarm.agents[mute])

    results = swarm.run(5, PaceConfig(deadline_s=1.0, first_deadline_s=1.0)).results

    assert [result.alerts for result in results if result.alerts] == [
        ("r01 did not answer tick 2 in time; not waited for",)
    ]
    assert all(mute not in result.answered and NodeId(0) in result.answered for result in results)


def test_a_robot_that_is_heard_again_is_waited_for_again(swarm: LiveSwarm) -> None:
    late = NodeId(1)
    aside = EventsExecutor(context=swarm.ros.context)  # runs the robot when the test says so
    swarm.ros.executor.remove_node(swarm.agents[late])
    aside.add_node(swarm.agents[late])
    pace = PaceConfig(deadline_s=1.0, first_deadline_s=1.0)

    swarm.run(2, pace)
    deadline = time.monotonic() + DEADLINE_S
    while swarm.steps[late] < 2 and time.monotonic() < deadline:
        spin_for(aside, 0.05)
    results = swarm.run(2, pace).results
    aside.remove_node(swarm.agents[late])

    assert [result.alerts for result in results] == [
        ("r01 answers again",),
        ("r01 did not answer tick 3 in time; not waited for",),
    ]


def test_a_robot_that_computes_beyond_the_deadline_is_waited_for(swarm: LiveSwarm) -> None:
    slow = NodeId(1)
    aside = EventsExecutor(context=swarm.ros.context)
    swarm.ros.executor.remove_node(swarm.agents[slow])
    aside.add_node(swarm.agents[slow])

    class Watching(Overseer):
        def computing_s(self, node: NodeId) -> float | None:
            used_s = super().computing_s(node)
            if self.looks[slow] >= ENOUGH_LOOKS:  # the deadline has long passed: now it gets done
                spin_for(aside, 0.05)
            return used_s

    overseer = Watching(3, computing={slow: 5.0})
    Lockstep(swarm.world, swarm.ros.executor, BRIEF, overseer).run()
    aside.remove_node(swarm.agents[slow])

    assert overseer.looks[slow] >= ENOUGH_LOOKS
    assert [result.alerts for result in overseer.results] == [()] * 3
    assert all(slow in result.answered for result in overseer.results)


def test_a_robot_that_computes_without_end_is_given_up(swarm: LiveSwarm) -> None:
    swarm.run(2)
    looping = NodeId(1)
    swarm.ros.executor.remove_node(swarm.agents[looping])
    overseer = Overseer(2, computing={looping: 30.0})

    Lockstep(swarm.world, swarm.ros.executor, BRIEF, overseer).run()

    assert [result.alerts for result in overseer.results] == [
        ("r01 did not answer tick 2 in time; not waited for",),
        (),
    ]
    assert overseer.looks[looping] > BRIEF.computing_limit_s / 30.0


def test_the_world_does_not_race_on_when_the_whole_swarm_is_silent(swarm: LiveSwarm) -> None:
    swarm.run(2)
    for agent in swarm.agents.values():
        swarm.ros.executor.remove_node(agent)
    swarm.run(1, BRIEF)
    lockstep = Lockstep(swarm.world, swarm.ros.executor, BRIEF, overseer := Overseer(3))

    began = time.monotonic()
    lockstep.run()

    assert time.monotonic() - began >= 3 * PERIOD
    assert [result.alerts for result in overseer.results] == [
        (f"the whole swarm is silent; until somebody answers, ticks take {PERIOD} s of wall time",),
        (),
        (),
    ]
    assert all(result.answered == {MISSION} for result in overseer.results)


def test_a_dead_robot_is_not_waited_for_at_all(swarm: LiveSwarm) -> None:
    swarm.run(2)
    gone = NodeId(2)
    swarm.ros.executor.remove_node(swarm.agents[gone])

    results = swarm.run(3, dead=(gone,)).results

    assert [result.alerts for result in results] == [(), (), ()]
    assert all(result.lost == {gone} and not result.truth.alive[gone] for result in results)


def test_the_operator_kills_a_robot(swarm: LiveSwarm) -> None:
    swarm.run(1)
    speaker = swarm.ros.speaker(topics.KILL_ROBOT)

    speaker.publish(UInt16(data=99))  # nobody: ignored
    speaker.publish(UInt16(data=2))

    def is_dead() -> bool:
        return NodeId(2) in swarm.run(1).results[-1].lost

    swarm.ros.wait(is_dead, "the death of r02")
    before = dict(swarm.steps)
    swarm.run(2)
    assert swarm.steps == {0: before[NodeId(0)] + 2, 1: before[NodeId(1)] + 2, 2: before[NodeId(2)]}


def test_simulated_time_stands_while_paused_and_goes_on_after(swarm: LiveSwarm) -> None:
    swarm.run(1)

    for service, is_paused in ((topics.PAUSE_SERVICE, True), (topics.RESUME_SERVICE, False)):
        client = swarm.ros.probe.create_client(Trigger, service)
        swarm.ros.wait(client.service_is_ready, service)
        reply = client.call_async(Trigger.Request())
        swarm.ros.wait(reply.done, f"a reply of {service}")
        assert reply.result().success
        assert swarm.world.is_paused is is_paused
    assert len(swarm.run(2).results) == 2


def test_in_real_time_nobody_is_waited_for(swarm: LiveSwarm) -> None:
    swarm.run(2)
    swarm.ros.executor.remove_node(swarm.agents[NodeId(0)])

    results = swarm.run(3, PaceConfig(real_time=True)).results

    assert [NodeId(0) in result.answered for result in results] == [False, False, False]
    assert all({NodeId(1), NodeId(2), MISSION} <= result.answered for result in results)


def test_a_world_that_cannot_keep_up_with_the_clock_still_hears_its_swarm(swarm: LiveSwarm) -> None:
    swarm.run(2)
    swarm.world.period_s = 0.002  # much less than a tick takes

    results = swarm.run(40, PaceConfig(real_time=True)).results

    assert any(result.answered or "again" in " ".join(result.alerts) for result in results[10:])
